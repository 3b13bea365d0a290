//! Connections of ports by name.

use data::Blueprint;

/// Two axes; Y publishes its charge, Z takes a disturbance and a temperature.
fn text(connection: &str) -> String {
    let axis = |name: &str, rest: &str| {
        format!(
            "[[axis]]\nname = \"{name}\"\ncommand = {{ unit = \"V\" }}\nposition = {{ unit = \"um\" \
             }}\n[[axis.component]]\ntype = \"actuator-gain\"\ngain = 0.1\n{rest}"
        )
    };
    let port = "[[axis.component]]\ntype = \"disturbance\"\nname = \"floor\"\ngain = 0.5\n";
    let charge = "[[axis.component]]\ntype = \"piezo-charge\"\ncapacitance = 2e-6\n";
    let y = axis("Y", "").replace("[[axis.component]]", &format!("{charge}[[axis.component]]"));
    let z = axis("Z", port);
    format!("piezoloop = 1\nkind = \"plant\"\nname = \"t\"\nstep = 1e-4\n{y}{z}{connection}")
}

fn read(connection: &str) -> Blueprint {
    Blueprint::parse(&text(connection), "t.toml").unwrap_or_else(|e| panic!("{e}"))
}

fn described(connection: &str) -> String {
    read(connection).check(components::COMPONENTS).err().map_or_else(String::new, |e| e.to_string())
}

fn connect(from: &str, to: &str) -> String {
    format!("[[connection]]\nfrom = \"{from}\"\nto = \"{to}\"\n")
}

#[test]
fn a_port_reads_the_signal_that_it_is_connected_to() {
    let connected = read(&connect("Y.displacement", "Z.floor.disturbance"));
    let mut system =
        connected.check(components::COMPONENTS).unwrap_or_else(|e| panic!("{e}")).build();
    let find = |name: &str| system.variables().find(name);
    assert_eq!(find("disturbance[2]"), None, "a connected port asks for no input");
    let (u, z) = (find("command[1]").expect("an input"), find("position[2]").expect("an output"));
    system.initialise(0.0).expect("rests");
    system.set(u, 20.0).expect("in range");
    system.advance(2e-4).expect("finite");
    // 20 V · 0.1 um/V · 0.5.
    assert!((system.get(z).expect("an output") - 1.0).abs() < 1e-12);
    let open = read("").check(components::COMPONENTS).unwrap_or_else(|e| panic!("{e}"));
    assert!(open.system().variables().find("disturbance[2]").is_some());
}

#[test]
fn a_signal_that_measures_something_else_is_refused_with_its_line() {
    let found = described(&connect("Y.charge", "Z.floor.disturbance"));
    assert!(found.contains("t.toml:27: connection[1].from"), "{found}");
    assert!(found.contains("charge is in C, and the port disturbance reads um"), "{found}");
}

#[test]
fn names_that_are_not_there_are_reported_with_those_that_are() {
    for (from, to, words) in [
        ("Q.displacement", "Z.floor.disturbance", "names no axis; axes are Y, Z"),
        ("Y.speed", "Z.floor.disturbance", "axis Y has no signal \"speed\"; it has command"),
        ("Y.displacement", "Z.flor.disturbance", "axis Z has no component \"flor\"; it has"),
        ("Y.displacement", "Z.floor.u", "no port \"u\" that can be connected; it has disturbance"),
        ("Y", "Z.floor.disturbance", "is no name of this kind; write 2 words"),
    ] {
        let found = described(&connect(from, to));
        assert!(found.contains(words), "{words} is not in: {found}");
        assert!(found.contains("t.toml:2"), "{found}");
    }
    let twice = connect("Y.displacement", "Z.floor.disturbance").repeat(2);
    let found = described(&twice);
    assert!(found.contains("connection[2].to: this port is connected already"), "{found}");
}

#[test]
fn what_is_written_is_read_as_the_same() {
    let first = read(&connect("Y.displacement", "Z.floor.disturbance"));
    let again = Blueprint::parse(&first.to_toml(), "again").unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(first, again);
    assert_eq!(again.connections.len(), 1);
}
