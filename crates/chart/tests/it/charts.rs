//! Charts as values: whatever they hold, they are drawn, and all files of one chart say the same.

use powergs_chart::render::labels::{Obstacles, Wish, crosses, leader, meet, overlap, place};
use powergs_chart::render::scene::{HINTS, Shape};
use powergs_chart::{
    Axis, Bar, Beside, Bin, Cell, Chart, Colour, Columns, Diagram, DiagramBlock, Entry, Form,
    Gauge, Label, Line, Mark, Name, Panel, Part, Place, Points, Rule, Scale, Sheet, Side, Size,
    Span, Style, Symbol, Weight, WidthError, Words,
};
use powergs_pixels::{Limits, RgbImage, Samples, decode};

/// Numbers that data may hold.
const NASTY: [f64; 9] =
    [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -0.0, -1.0, 1e300, -1e300, f64::MIN_POSITIVE];

fn grey(width: u32, height: u32) -> RgbImage {
    RgbImage::from_fn(width, height, |_, _| [7; 3])
}

fn every_symbol() -> Vec<Entry> {
    let [a, b] = [Colour::BLUE, Colour::INK];
    let symbols = [
        Symbol::Fill(a),
        Symbol::Dot(a),
        Symbol::Ring(a, b),
        Symbol::Square(a),
        Symbol::Line(a),
        Symbol::Curve(a),
        Symbol::Dashed(a),
        Symbol::None,
    ];
    symbols.into_iter().enumerate().map(|(i, s)| Entry::new(format!("entry {i}"), s)).collect()
}

fn every_side() -> [Side; 8] {
    [
        Side::Free,
        Side::Right,
        Side::Left,
        Side::Above,
        Side::Below,
        Side::AboveLeft,
        Side::BelowLeft,
        Side::AboveRight,
    ]
}

/// Every mark there is, from `values`.
fn every_mark(values: &[f64], text: &str) -> Vec<Mark> {
    let points: Vec<Place> =
        values.iter().flat_map(|&x| values.iter().map(move |&y| (x, y))).collect();
    let bar = |(i, &v): (usize, &f64)| {
        let part = Part { value: v, colour: Colour::SKY, label: text.into() };
        let bar = Bar::new(i % 3, vec![part.clone(), part]).end(text);
        Bar { lane: (i % 2, 2), interval: Some((v, -v)), ..bar }
    };
    let bin = |&v: &f64| Bin {
        from: v,
        to: v + 1.0,
        height: v,
        colour: Colour::GREEN,
        label: text.into(),
    };
    let span = |&v: &f64| Span { track: 0, from: v, to: 2.0 * v, colour: Colour::ORANGE };
    let cell = |_: &f64| Cell {
        column: 0,
        row: 0,
        colour: Colour::at(values.first().copied().unwrap_or(0.5)),
        label: text.into(),
        dot: Some((Colour::INK, true)),
    };
    let pair = |&v: &f64| [Some(v), Some(-v)];
    let dots = Points::dots(points.clone(), Colour::INK, Size::Huge);
    let mut marks = vec![
        Mark::Bars(values.iter().enumerate().map(bar).collect()),
        Mark::Tornado {
            rows: values.iter().map(pair).collect(),
            colours: [Colour::BLUE, Colour::ORANGE],
        },
        Mark::Histogram { bins: values.iter().map(bin).collect(), outlined: true },
        Mark::Line(Line {
            weight: Weight::Bold,
            dashed: true,
            ..Line::curve(points.clone(), Colour::INK)
        }),
        Mark::Line(Line { weight: Weight::Hair, ..Line::thin(points.clone(), Colour::INK) }),
        Mark::Points(Points { form: Form::Square, ring: Some(Colour::BLUE), ..dots.clone() }),
        Mark::Points(Points { crowd: true, size: Size::Small, ..dots }),
        Mark::Heat(values.iter().map(cell).collect()),
        Mark::Spans {
            spans: values.iter().map(span).collect(),
            labels: values.iter().map(|v| (span(v), text.to_owned())).collect(),
        },
        Mark::Image { image: grey(3, 2), sharp: true },
        Mark::Gauge(Gauge { at: 0.5, labels: values.iter().map(|v| (*v, text.into())).collect() }),
    ];
    for (i, &v) in values.iter().enumerate() {
        let at = if i % 2 == 0 { Rule::X(v) } else { Rule::Y(v) };
        marks.push(Mark::Rule { at, colour: Colour::GREY, dashed: true });
        marks.push(Mark::Cross((v, v)));
        let side = every_side()[i % 8];
        marks.push(Mark::Label(Label { words: text.into(), at: (v, -v), side }));
    }
    marks
}

/// A panel with every mark and every part.
fn panel(x: Scale, y: Scale, values: &[f64], text: &str) -> Panel {
    let mut panel = Panel::new(Axis::new(text, x), Axis::new(text, y)).heading(Words::bold(text));
    panel.marks = every_mark(values, text);
    panel.remark = Some(Words::note(text));
    panel.over = values.iter().map(|&v| (v, v, Words::bold(text))).collect();
    panel.right = values.iter().map(|&v| (v, vec![text.into(), text.into()])).collect();
    panel.colours = Some((text.into(), text.into()));
    panel
}

fn scales(values: &[f64], names: &[&str]) -> Vec<Scale> {
    let mut scales = vec![Scale::Names(names.iter().map(|n| Name::from(*n)).collect())];
    for &a in values {
        scales.push(Scale::from_zero(a));
        for &b in values {
            scales.push(Scale::linear(a, b));
            scales.push(Scale::logarithmic(a, b));
        }
    }
    scales.push(Scale::around(values.iter().copied(), 0.1));
    scales
}

fn whole(panels: Vec<Panel>, text: &str) -> Chart {
    let entries = every_symbol();
    Chart { panels, columns: Columns::Are(2), ..Chart::new("all", "Everything", text) }
        .legend(entries.clone())
        .legend([Entry::fill(text, Colour::INK)])
        .beside(Beside::Entries { title: text.into(), entries })
        .beside(Beside::Scale { title: text.into(), labels: vec![(0.5, text.into())] })
        .beside(Beside::List { title: text.into(), rows: vec![(text.into(), text.into())] })
        .note(text)
}

/// Draws a chart; no number that is none may be written.
fn drawn(chart: &Chart) -> String {
    let svg = chart.svg(Style::default()).expect("drawn");
    for attribute in
        svg.split('<').filter(|tag| !tag.starts_with("text") && !tag.starts_with("desc"))
    {
        assert!(!attribute.contains("NaN") && !attribute.contains("inf"), "{attribute}");
    }
    svg
}

#[test]
fn numbers_that_are_none_are_drawn() {
    for scale in scales(&NASTY, &["a", "b"]) {
        let panel = panel(scale.clone(), scale, &NASTY, "text");
        drawn(&Chart::new("nasty", "Nasty", "").panel(panel));
    }
}

#[test]
fn empty_charts_and_single_points_are_drawn() {
    drawn(&Chart::new("none", "None", ""));
    drawn(&whole(Vec::new(), ""));
    for values in [&[][..], &[0.0], &[7.0]] {
        for scale in scales(values, &[]) {
            drawn(&whole(vec![panel(scale.clone(), scale, values, "")], ""));
        }
    }
    drawn(&Chart::new("dot", "Dot", "").panel(Panel::picture(grey(0, 0), "")));
    drawn(&Chart::new("dot", "Dot", "").panel(Panel::picture(grey(1, 1), "")));
}

#[test]
fn huge_labels_are_drawn() {
    let text = "an absurdly long label\nwith <signs> & \u{7} characters, \u{1F600} ".repeat(40);
    let scale = Scale::Names((0..40).map(|_| Name::from(text.as_str())).collect());
    let linear = Scale::linear(0.0, 1.0);
    let values = [0.25, 0.5, 0.75];
    let svg = drawn(&whole(
        vec![
            panel(linear.clone(), scale.clone(), &values, &text),
            panel(scale, linear, &values, &text),
        ],
        &text,
    ));
    assert!(svg.contains("&lt;signs&gt;") && !svg.contains("<signs>") && !svg.contains('\u{7}'));
}

/// Names of values end before the next upright axis, and no two of them look alike.
#[test]
fn names_on_upright_axes_are_told_apart() {
    let gauge = |at: f64, names: &[&str]| {
        let height = |i: usize| (i as f64 + 0.5) / names.len() as f64;
        let labels = names.iter().enumerate().map(|(i, name)| (height(i), (*name).into()));
        Mark::Gauge(Gauge { at, labels: labels.collect() })
    };
    let shown = |names: &[&str], axes: usize| -> Vec<(String, [f64; 4])> {
        let empty = vec![""; axes];
        let panel = Panel::new(Axis::names(empty), Axis::new("", Scale::linear(0.0, 1.0)).hidden());
        let marks = (1..axes).map(|i| gauge(i as f64 + 0.5, &["!"]));
        let panel = marks.fold(panel.mark(gauge(0.5, names)), Panel::mark);
        let chart = Chart::new("gauges", "title", "subtitle").panel(panel);
        svg_texts(&chart.svg(Style::default()).expect("drawn"))
    };
    let texts = |names: &[&str], axes| -> Vec<String> {
        let all = shown(names, axes);
        let next = all.iter().find(|(text, _)| text == "!").map_or(f64::INFINITY, |(_, b)| b[0]);
        let own = all.into_iter().filter(|(t, _)| t != "!" && t != "title" && t != "subtitle");
        own.map(|(text, area)| {
            assert!(area[2] <= next, "{text}: {area:?} and the next at {next}");
            text
        })
        .collect()
    };
    let devices = ["lpddr4-3200-x16x8", "lpddr5-6400-x16x8", "lpddr5x-8533-x16x8"];
    assert_eq!(texts(&devices, 2), devices);
    assert_eq!(texts(&devices, 8), ["lpddr4-3200", "lpddr5-6400", "lpddr5x-8533"]);
    for axes in [10, 14, 18] {
        let short = texts(&devices, axes);
        assert_ne!(short[1], short[2], "{axes} axes");
        assert_ne!(short[0], short[1], "{axes} axes");
    }
    assert_eq!(texts(&["one-and-only"; 2], 3), ["one-and-only"; 2]);
}

fn chart() -> Chart {
    let x = Axis::new("length, µm (logarithmic)", Scale::logarithmic(0.1, 1000.0));
    let y = Axis::new("power, mW", Scale::from_zero(93.0));
    let points: Vec<Place> =
        (0..20).map(|i| (0.1 * 1.6f64.powi(i), f64::from(i * i) / 4.0)).collect();
    let curve = Panel::new(x, y)
        .heading(Words::bold("left (<&>)"))
        .line(Line::curve(points.clone(), Colour::BLUE))
        .points(Points::dots(points, Colour::ORANGE, Size::Large))
        .label("the λ of ρ²", (10.0, 25.0), Side::Free)
        .dashed(Rule::Y(60.0), Colour::VERMILION);
    let bars = (0..3).map(|i| {
        Bar::new(i, vec![Part::new(2.0, Colour::SKY), Part::new(1.0, Colour::GREEN)]).end("3.0")
    });
    let bars =
        Panel::new(Axis::new("energy, mJ", Scale::from_zero(3.0)), Axis::names(["a", "b", "c"]))
            .mark(Mark::Bars(bars.collect()));
    Chart::new("example", "An example", "one line of context")
        .legend([Entry::fill("sky", Colour::SKY), Entry::new("line", Symbol::Line(Colour::BLUE))])
        .columns(2)
        .panel(curve)
        .panel(bars)
        .note("a note")
}

/// Texts of an SVG in order, with their boxes.
fn svg_texts(svg: &str) -> Vec<(String, [f64; 4])> {
    let number = |tag: &str, name: &str| -> f64 {
        let (_, rest) = tag.split_once(&format!(" {name}=\"")).expect("an attribute");
        rest.split('"').next().and_then(|v| v.parse().ok()).expect("a number")
    };
    let mut texts = Vec::new();
    for tag in svg.split("<text").skip(1) {
        let (attributes, rest) = tag.split_once('>').expect("a tag");
        let text = rest.split("</text>").next().expect("text");
        let text = text.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
        let (x, y, size) =
            (number(attributes, "x"), number(attributes, "y"), number(attributes, "font-size"));
        let width = number(attributes, "textLength");
        let area = if attributes.contains("rotate") {
            [x - 0.8 * size, y - width, x + 0.2 * size, y]
        } else {
            [x, y - 0.8 * size, x + width, y + 0.2 * size]
        };
        texts.push((text, area));
    }
    texts
}

/// What a reader finds in a PDF, blanks as one; `None` where there is no `pdftotext`.
fn pdf_text(pdf: &[u8]) -> Option<String> {
    let file = std::env::temp_dir().join(format!("powergs-{}.pdf", std::process::id()));
    std::fs::write(&file, pdf).expect("a temporary file");
    let run = std::process::Command::new("pdftotext").arg("-raw").arg(&file).arg("-").output();
    std::fs::remove_file(&file).expect("it was written");
    let Ok(run) = run else {
        eprintln!("no `pdftotext`: texts of PDF files are not read");
        return None;
    };
    let text = String::from_utf8(run.stdout).expect("UTF-8");
    Some(text.split_whitespace().collect::<Vec<_>>().join(" "))
}

#[test]
fn svg_pdf_and_png_say_the_same() {
    let chart = chart();
    let svg = svg_texts(&chart.svg(Style::default()).expect("SVG"));
    let words: Vec<&str> = svg.iter().map(|t| t.0.as_str()).collect();
    for expected in ["An example", "one line of context", "left (<&>)", "the λ of ρ²", "power, mW"]
    {
        assert!(words.contains(&expected), "{expected} is missing in {words:?}");
    }
    let pdf = chart.pdf(Style::default()).expect("PDF");
    if let Some(text) = pdf_text(&pdf) {
        // Upright text and what stands above it comes in an order of the reader's.
        for words in words.iter().map(|words| words.trim()) {
            assert!(text.contains(words), "{words} is missing in {text}");
        }
    }
    let png = chart.png(Style::default()).expect("PNG");
    let picture = decode(&png, Limits { side: 1920, bytes: 1 << 26 }).expect("a PNG");
    assert_eq!((picture.width, picture.height, picture.channels), (1920, 1080, 3));
    let Samples::Eight(pixels) = &picture.samples else { panic!("8 bits") };
    for (text, area) in &svg {
        let [l, t, r, b] = area.map(|v| (1.5 * v).round() as u32);
        assert!(r <= 1920 && b <= 1080, "{text} is cut off");
        let pixel = |x: u32, y: u32| &pixels[3 * (y * 1920 + x) as usize..][..3];
        let dark = |x: u32, y: u32| pixel(x, y).iter().any(|c| *c < 128);
        let ink =
            (l..r).flat_map(|x| (t..b).map(move |y| (x, y))).filter(|p| dark(p.0, p.1)).count();
        assert!(ink >= text.trim().chars().count() * 3, "{text}: {ink} dark pixels");
    }
}

#[test]
fn a_pdf_is_well_formed() {
    let mut chart = chart();
    chart = chart.panel(Panel::picture(RgbImage::from_fn(5, 4, |x, y| [x as u8, y as u8, 9]), "p"));
    let pdf = chart.pdf(Style::default()).expect("PDF");
    assert_eq!(pdf, chart.pdf(Style::default()).expect("PDF"), "the same bytes");
    assert!(pdf.starts_with(b"%PDF-1.") && pdf.trim_ascii_end().ends_with(b"%%EOF"));
    // A part of the font is in it, not all of its 750 kB.
    assert!((10_000..100_000).contains(&pdf.len()), "{} bytes", pdf.len());
}

#[test]
fn the_same_chart_is_the_same_bytes() {
    let once =
        (chart().svg(Style::default()).expect("SVG"), chart().png(Style::default()).expect("PNG"));
    let other = std::thread::spawn(|| {
        (chart().svg(Style::default()).expect("SVG"), chart().png(Style::default()).expect("PNG"))
    });
    assert!(once == other.join().expect("drawn"));
}

#[test]
fn labels_cover_no_mark_and_no_label() {
    let frame = [0.0, 0.0, 1000.0, 600.0];
    let at = |i: u32| (f64::from(i * 7919 % 1000), f64::from(i * 104_729 % 600));
    let points: Vec<(f64, f64)> = (0..60).map(at).collect();
    let marks: Vec<[f64; 4]> =
        points.iter().map(|(x, y)| [x - 9.0, y - 9.0, x + 9.0, y + 9.0]).collect();
    let wish = |&at: &(f64, f64)| Wish { at, size: (90.0, 20.0), side: Side::Free, reach: 230.0 };
    let wishes: Vec<Wish> = points.iter().map(wish).collect();
    let obstacles = Obstacles { solid: marks.clone(), ..Obstacles::default() };
    let places = place(&wishes, &obstacles, frame);
    let placed: Vec<[f64; 4]> = places.iter().flatten().copied().collect();
    assert!(placed.len() > 40, "{} of 60 found a place", placed.len());
    for (i, a) in placed.iter().enumerate() {
        assert!(a[0] >= frame[0] && a[1] >= frame[1] && a[2] <= frame[2] && a[3] <= frame[3]);
        assert!(marks.iter().all(|m| !overlap(*a, *m)), "label {i} covers a mark");
        assert!(placed[..i].iter().all(|b| !overlap(*a, *b)), "label {i} covers a label");
    }
}

#[test]
fn lines_to_the_labels_of_near_points_do_not_cross() {
    let frame = [0.0, 0.0, 1700.0, 700.0];
    let wide = [(4.0, 21.0), (15.0, -15.0), (0.0, 20.0)].map(|step| (step, 330.0));
    let short = [(21.0, 4.0), (0.0, 20.0)].map(|step| (step, 40.0));
    for (step, width) in wide.into_iter().chain(short) {
        let at = |i: usize| (300.0 + step.0 * i as f64, 400.0 + step.1 * i as f64);
        let points: Vec<(f64, f64)> = (0..5).map(at).collect();
        let mark = |(x, y): &(f64, f64)| [x - 9.0, y - 9.0, x + 9.0, y + 9.0];
        let solid = points.iter().map(mark).collect();
        let obstacles = Obstacles { solid, ..Obstacles::default() };
        let wish = |&at: &(f64, f64)| Wish {
            at,
            size: (width, 20.0),
            side: Side::Free,
            reach: f64::INFINITY,
        };
        let wishes: Vec<Wish> = points.iter().map(wish).collect();
        let places = place(&wishes, &obstacles, frame);
        let labels: Vec<[f64; 4]> = places.iter().flatten().copied().collect();
        assert_eq!(labels.len(), points.len(), "{step:?}");
        let lines: Vec<_> = points.iter().zip(&labels).map(|(p, l)| leader(*p, *l)).collect();
        for (i, line) in lines.iter().enumerate() {
            let Some(line) = line else { continue };
            let mut others = labels.iter().enumerate().filter(|(j, _)| *j != i);
            assert!(others.all(|(_, area)| !crosses(*line, *area)), "{step:?}: label {i}");
            let other = lines.iter().skip(i + 1).flatten();
            assert!(other.clone().all(|other| !meet(*line, *other)), "{step:?}: line {i}");
        }
    }
}

#[test]
fn a_label_keeps_off_curves_and_takes_its_side_where_that_is_free() {
    let frame = [0.0, 0.0, 1000.0, 600.0];
    let wish = Wish { at: (500.0, 300.0), size: (80.0, 20.0), side: Side::Right, reach: 230.0 };
    let wished = std::slice::from_ref(&wish);
    let free = place(wished, &Obstacles::default(), frame);
    assert!(free[0].is_some_and(|[l, ..]| l > 500.0 && l < 520.0), "{free:?}");
    let curve = [(505.0, 300.0), (900.0, 302.0)];
    let below = Obstacles { curves: vec![curve], ..Obstacles::default() };
    let moved = place(wished, &below, frame)[0].expect("room");
    assert!(!crosses(curve, moved), "{moved:?}");
    // Faint lines and crowds are covered where there is no other place, curves never.
    let rows = (0..60).map(|i| [(0.0, 10.0 * f64::from(i)), (1000.0, 10.0 * f64::from(i))]);
    let faint = Obstacles { faint: rows.clone().collect(), ..Obstacles::default() };
    assert!(place(wished, &faint, frame)[0].is_some());
    let curves = Obstacles { curves: rows.collect(), ..Obstacles::default() };
    assert_eq!(place(wished, &curves, frame), [None]);
}

#[test]
fn lines_cross_rectangles_by_their_middle_too() {
    let area = [10.0, 10.0, 20.0, 20.0];
    for (line, expected) in [
        ([(0.0, 15.0), (30.0, 15.0)], true),
        ([(15.0, 0.0), (15.0, 30.0)], true),
        ([(0.0, 0.0), (30.0, 30.0)], true),
        ([(12.0, 12.0), (13.0, 13.0)], true),
        ([(0.0, 25.0), (30.0, 25.0)], false),
        ([(0.0, 12.0), (9.0, 12.0)], false),
        ([(0.0, 25.0), (25.0, 0.0)], true),
        ([(0.0, 15.0), (15.0, 0.0)], false),
    ] {
        assert_eq!(crosses(line, area), expected, "{line:?}");
    }
}

#[test]
fn columns_are_narrow_and_their_text_is_no_smaller() {
    let width = |sheet| {
        let svg = chart().svg(Style { sheet, title: false }).expect("SVG");
        assert!(!svg.contains(">An example</text>") && svg.contains("power, mW"));
        let width = svg.split("width=\"").nth(1).and_then(|w| w.split('"').next());
        let view = svg.split("viewBox=\"0 0 ").nth(1).and_then(|v| v.split(' ').next());
        let number = |text: Option<&str>| -> f64 {
            text.and_then(|t| t.trim_end_matches("in").parse().ok()).expect("a number")
        };
        (number(width), number(view))
    };
    let read = |text: &str| -> Sheet { text.parse().expect(text) };
    let widths = ["3in", "3.5in", "88mm", "11 cm", "360pt", "6.75in", "20in"].map(read);
    for sheet in [Sheet::Column, Sheet::Page].into_iter().chain(widths) {
        let (inches, units) = width(sheet);
        assert!((inches - sheet.inches()).abs() < 0.005);
        // Normal text has 18 units.
        assert!(18.0 * inches * 72.0 / units >= 6.99, "{sheet:?}");
    }
    // What is narrower than labels need gets smaller text.
    assert!((width(read("1.5in")).0 - 1.5).abs() < 0.005);
}

#[test]
fn a_width_is_a_number_with_its_unit_or_a_name() {
    let inches = |text: &str| text.parse::<Sheet>().map(Sheet::inches);
    for text in ["3.5in", "88.9mm", "8.89 cm", "252pt"] {
        assert_eq!(inches(text), Ok(3.5), "{text}");
    }
    for sheet in Sheet::ALL.into_iter().chain(["3.5in".parse().expect("a width")]) {
        assert_eq!(sheet.to_string().parse(), Ok(sheet));
    }
    for text in ["", "in", "3.5", "wide", "-2in", "1e1in", "NaNin", "infin", "1.2.3in", "2 m"] {
        assert_eq!(inches(text), Err(WidthError::Unread), "{text}");
    }
    for text in ["1.49in", "21in", "0mm", &format!("{}pt", "9".repeat(400))] {
        assert_eq!(inches(text), Err(WidthError::Range), "{text}");
    }
}

#[test]
fn a_png_says_how_many_pixels_are_an_inch() {
    for (sheet, wide) in [(Sheet::Column, 3.33), (Sheet::Page, 7.0)] {
        let png = chart().png(Style { sheet, title: true }).expect("PNG");
        let at = png.windows(4).position(|w| w == b"pHYs").expect("a size in print") + 4;
        let number = |i: usize| u32::from_be_bytes(png[i..i + 4].try_into().expect("4 bytes"));
        let (across, metre) = (number(16), png[at + 8]);
        assert_eq!((number(at), metre), (number(at + 4), 1));
        let inches = f64::from(across) / (f64::from(number(at)) * 0.0254);
        assert!((inches - wide).abs() < 0.01, "{inches}");
    }
}

#[test]
fn amounts_that_do_not_begin_at_zero_have_a_mark() {
    let strokes = |axis: Axis| {
        let x = Axis::new("x", Scale::linear(0.0, 1.0));
        let chart = Chart::new("b", "B", "").panel(Panel::new(x, axis));
        let scene = chart.scene(Style::default()).expect("drawn");
        let is_stroke = |s: &&Shape| match s {
            Shape::Line { points, .. } => {
                let [(x0, y0), (x1, y1)] = points[..] else { return false };
                x0 != x1 && y0 != y1
            }
            _ => false,
        };
        scene.shapes.iter().filter(is_stroke).count()
    };
    assert_eq!(strokes(Axis::new("y", Scale::linear(0.0, 9.0))), 0);
    assert_eq!(strokes(Axis::new("y", Scale::linear(5.0, 9.0))), 2);
    assert_eq!(strokes(Axis::new("y", Scale::linear(5.0, 9.0)).positions()), 0);
    assert_eq!(strokes(Axis::new("y", Scale::logarithmic(5.0, 9.0))), 0);
    assert_eq!(Axis::new("power, W", Scale::logarithmic(5.0, 9.0)).words(), "power, W (log)");
}

#[test]
fn marks_say_their_series_name_and_values_to_a_pointer() {
    let scene = chart().scene(Style::default()).expect("a page");
    let said = |words: &str| scene.hints.iter().filter(|hint| hint.words == words).count();
    assert_eq!(said("sky · b · energy, mJ: 2"), 1, "{:?}", scene.hints);
    // No entry of the legend says what green is.
    assert_eq!(said("c · energy, mJ: 1"), 1, "{:?}", scene.hints);
    let (x, y) = (0.1 * 1.6f64.powi(6), 36.0 / 4.0);
    let point = format!("length, µm (logarithmic): {x:.3} · power, mW: {y}");
    assert_eq!(said(&point), 1, "{:?}", scene.hints);
    assert_eq!(said(&format!("line · {point}")), 1, "{:?}", scene.hints);
    let svg = chart().svg(Style::default()).expect("SVG");
    assert!(svg.contains("<title>sky · b · energy, mJ: 2</title></rect>"), "{svg}");
}

#[test]
fn of_a_crowd_the_uppermost_marks_speak() {
    let axis = || Axis::new("", Scale::linear(0.0, 100.0));
    let crowd = (0..90).flat_map(|x| (0..90).map(move |y| (f64::from(x), f64::from(y))));
    let last = (99.5, 99.5);
    let panel = Panel::new(axis(), axis())
        .points(Points::dots(crowd, Colour::BLUE, Size::Small))
        .points(Points::dots([last], Colour::GREEN, Size::Large));
    let chart = Chart::new("crowd", "", "").panel(panel);
    let hints = chart.scene(Style::default()).expect("a page").hints;
    assert_eq!(hints.len(), HINTS);
    assert_eq!(hints.last().map(|hint| hint.words.as_str()), Some("99.5 · 99.5"));
}

#[test]
fn arrows_of_a_diagram_pass_what_is_between_their_ends() {
    let block = |after| DiagramBlock {
        title: "a block".into(),
        lines: vec!["with a line that is so long that it has to be wrapped ".repeat(4)],
        colour: Colour::SKY,
        is_part: false,
        after,
        reads: "reads".into(),
        writes: String::new(),
        stores: vec![["store".into(), "1 KiB".into()]],
    };
    let mut chart = Chart::new("machine", "a diagram", "of blocks");
    chart.diagram = Some(Diagram {
        memory: ["DRAM".into(), "1 channel".into()],
        blocks: vec![block(None), block(Some(0)), block(Some(0)), block(Some(0))],
    });
    for sheet in Sheet::ALL {
        let scene = chart.scene(Style { sheet, title: true }).unwrap();
        let boxes: Vec<[f64; 4]> = scene.shapes.iter().filter_map(outline).collect();
        // The memory and four blocks; the paths to the last two of them have lanes of their own.
        assert_eq!(boxes.len(), 5, "{sheet:?}");
        let right = boxes.iter().map(|b| b[2]).fold(0.0, f64::max);
        let paths = scene.shapes.iter().filter_map(|shape| match shape {
            Shape::Line { points, .. } if points.len() == 4 => Some(points.clone()),
            _ => None,
        });
        let lanes: Vec<f64> = paths.map(|points| points[1].0).collect();
        assert_eq!(lanes.len(), 2, "{sheet:?}");
        assert!(lanes[0] != lanes[1], "{sheet:?}: two paths in one lane");
        let is_free = |x: &f64| *x > right && *x < scene.size.0;
        assert!(lanes.iter().all(is_free), "{sheet:?}: {lanes:?} right of {right}");
    }
}

/// The corners of a closed line around a box.
fn outline(shape: &Shape) -> Option<[f64; 4]> {
    match shape {
        Shape::Line { points, .. } if points.len() == 5 && points[0] == points[4] => {
            Some([points[0].0, points[0].1, points[2].0, points[2].1])
        }
        _ => None,
    }
}
