//! Ports as the terminals of FMI 3.0.

use super::{Offered, Port};

/// The terminals of FMI 3.0 for the ports that a plant has.
pub(crate) fn terminals(variables: &model::VariableTable, offered: &[Offered]) -> String {
    let bundles = variables.bundles();
    let mut text = String::new();
    for port in Port::ALL.into_iter().filter(|port| offered.iter().any(|o| o.port == *port)) {
        let mut members = String::new();
        for (base, kind) in port.members() {
            for bundle in &bundles {
                let own = offered.iter().filter(|o| o.port == port).flat_map(|o| &o.variables);
                let is_own = bundle.name == *base
                    || (bundle.name.starts_with(&format!("{base}["))
                        && own.clone().any(|name| *name == bundle.name));
                if is_own {
                    members.push_str(&format!(
                        "      <TerminalMemberVariable variableName=\"{0}\" memberName=\"{0}\" variableKind=\"{kind}\"/>\n",
                        bundle.name
                    ));
                }
            }
        }
        let (name, y) = (port.name(), 60 - 60 * (port as i32));
        text.push_str(&format!(
            "    <Terminal name=\"{name}\" matchingRule=\"plug\" description=\"{}\">\n{members}      \
             <TerminalGraphicalRepresentation x1=\"90\" y1=\"{}\" x2=\"110\" y2=\"{}\" iconBaseName=\"{name}\" \
             defaultConnectionColor=\"{}\"/>\n    </Terminal>\n",
            port.sentence(),
            y - 10,
            y + 10,
            port.colour(),
        ));
    }
    if text.is_empty() { text } else { format!("  <Terminals>\n{text}  </Terminals>\n") }
}

impl Port {
    /// What the port carries and how it counts.
    fn sentence(self) -> &'static str {
        match self {
            Self::Mechanical => {
                "Force on the tip, positive towards greater positions, its position and its velocity"
            }
            Self::Electrical => "Voltage at the actuator, current into it and its charge",
            Self::Thermal => "Temperature of the actuator and heat that it gives off",
        }
    }

    /// Red, green and blue of its lines.
    fn colour(self) -> &'static str {
        match self {
            Self::Mechanical => "0 127 0",
            Self::Electrical => "0 0 255",
            Self::Thermal => "191 0 0",
        }
    }
}
