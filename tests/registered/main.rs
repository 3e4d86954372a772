//! What is registered from outside of the program: a dataflow with its stage, and rules of units.
//! They are there for the whole process, which is why these tests have one of their own.

use std::sync::Once;

// Their `main` is not called here.
#[allow(dead_code)]
#[path = "../../examples/own_flow.rs"]
mod example_flow;
#[allow(dead_code)]
#[path = "../../examples/own_unit.rs"]
mod example_unit;
mod own_flow;
mod own_unit;

/// Registers everything, before anything else asks.
fn registered() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        powergs_sim::extend::flow::register(&example_flow::UnsortedFlow)
            .expect("nobody has asked yet");
        own_unit::register_rules();
    });
}
