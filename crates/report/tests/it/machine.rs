//! Pictures of machines: all that a machine has is in them, and nothing lies over anything else.

use powergs_base::config::embedded::MACHINES;
use powergs_chart::render::scene::{Scene, Shape, Text};
use powergs_chart::{Chart, Sheet, Style};
use powergs_core::machine::Machine;
use powergs_core::run::System;
use powergs_core::stage::{hardware, stage};
use powergs_report::machine::chart;

fn machines() -> impl Iterator<Item = (Machine, Chart)> {
    MACHINES.iter().map(|file| {
        let system = System::named(file.name).expect("machines that come with the program work");
        let machine = system.machine().clone();
        let chart = chart(&machine);
        (machine, chart)
    })
}

fn texts(scene: &Scene) -> Vec<&Text> {
    let texts = scene.shapes.iter().filter_map(|shape| match shape {
        Shape::Text(text) => Some(text),
        _ => None,
    });
    texts.collect()
}

#[test]
fn pictures_show_every_unit_and_buffer_of_every_machine() {
    for (machine, chart) in machines() {
        let (name, inventory) = (&machine.name, machine.inventory());
        let svg = chart.svg(Style::default()).unwrap();
        let diagram = chart.diagram.as_ref().unwrap();
        let says = |text: &str| svg.contains(&format!(">{text}<"));
        for (id, unit) in hardware().units() {
            let count = inventory.units[id.index()];
            let mut own = hardware().buffers().filter(|(b, _)| hardware().stage_of(*b) == id);
            let stores = own.any(|(buffer, _)| inventory.memories[buffer.index()].banks > 0);
            assert_eq!(says(unit.words), count > 0 || stores, "{name}: {count} {}", unit.key);
            let is_one = |word: &str| if count == 1 { word.to_owned() } else { format!("{word}s") };
            let word = is_one(if stage(id).has_lanes { "lane" } else { "unit" });
            let counted = format!("{count} {word}");
            assert!(count == 0 || says(&counted), "{name}: {counted} of {}", unit.key);
        }
        for (id, buffer) in hardware().buffers() {
            let memory = inventory.memories[id.index()];
            // A phase may have the name of a buffer.
            let stores = diagram.blocks.iter().flat_map(|block| &block.stores);
            let times = stores.filter(|[store, _]| store == buffer.name).count();
            assert_eq!(times, usize::from(memory.banks > 0), "{name}: buffer {}", buffer.name);
            assert!(times == 0 || says(buffer.name), "{name}: buffer {}", buffer.name);
            let size = memory.bank.to_string();
            assert!(memory.banks == 0 || svg.contains(&size), "{name}: {} {size}", buffer.name);
        }
        assert!(svg.contains(&machine.dram_peak().to_string()), "{name}: the rate of its memory");
    }
}

#[test]
fn no_text_of_a_picture_lies_over_another_or_is_cut() {
    for (machine, chart) in machines() {
        for sheet in Sheet::ALL {
            let scene = chart.scene(Style { sheet, title: true }).unwrap();
            let texts = texts(&scene);
            for (i, text) in texts.iter().enumerate() {
                let (place, [l, t, r, b]) = (format!("{}, {sheet:?}", machine.name), text.area());
                let is_inside = l >= 0.0 && t >= 0.0 && r <= scene.size.0 && b <= scene.size.1;
                assert!(is_inside, "{place}: {:?} leaves the page", text.text);
                assert!(!text.text.ends_with('…'), "{place}: {:?} is cut", text.text);
                for other in &texts[i + 1..] {
                    let [ol, ot, or, ob] = other.area();
                    let meet = l < or && ol < r && t < ob && ot < b;
                    assert!(!meet, "{place}: {:?} lies over {:?}", text.text, other.text);
                }
            }
        }
    }
}

#[test]
fn pictures_are_the_same_bytes_each_time() {
    let svgs = || -> Vec<String> {
        machines().map(|(_, chart)| chart.svg(Style::default()).unwrap()).collect()
    };
    assert_eq!(svgs(), svgs());
}
