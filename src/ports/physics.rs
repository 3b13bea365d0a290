//! What makes a mechanical and an electrical port physical: passive force and tip, reciprocal charge.

use anyhow::{Context as _, bail};
use data::{ComponentBlueprint, Value};
use model::Stage;

use super::{Maker, Offered, Port, Stated, declaration, gives};

impl Maker<'_> {
    pub(super) fn mechanical(
        &mut self,
        added_force: bool,
        offered: &mut Offered,
    ) -> anyhow::Result<()> {
        if added_force {
            self.make_stiffness_that_of_the_tip(offered)?;
        }
        let Some(stiffness) = self.stiffness()? else { bail!("the axis reads no force") };
        if !(stiffness.is_finite() && stiffness > 0.0) {
            bail!(
                "a small force does not move the tip: a component behind it holds it (backlash, friction at rest); \
                 put load-force in the blueprint where the force acts"
            );
        }
        if let Some((share, frequency)) = self.probe()?.gives_back()? {
            let message = format!(
                "a force at the tip would get out more energy than it puts in: at {frequency:.4} Hz the velocity runs \
                 against the force, by {:.2} % of its greatest answer",
                100.0 * share
            );
            if added_force {
                bail!(
                    "{message}. The mode in front of the tip is not collocated with it (a mode of negative share?); put \
                     load-force in the blueprint where the force acts"
                );
            }
            offered.notes.push(message);
        }
        let axis = self.axis();
        let behind: Vec<String> = axis
            .components
            .iter()
            .skip_while(|component| !gives(component, "tip"))
            .skip(1)
            .filter(|component| component.enabled)
            .map(|component| component.kind.clone())
            .collect();
        let couplings = self.blueprint.couplings.iter();
        let couplings: Vec<String> = couplings
            .filter(|coupling| coupling.axes.iter().any(|axis| axis == self.name))
            .map(|coupling| coupling.component.kind.clone())
            .collect();
        let left_out: Vec<String> = couplings.into_iter().chain(behind).collect();
        if !left_out.is_empty() {
            offered.notes.push(format!(
                "tip is where the force acts; what {} make of it is in position alone",
                left_out.join(", ")
            ));
        }
        Ok(())
    }

    /// Where a mode with a gain stands between force and tip, the force's component gets the gain times the
    /// stiffness, so that the tip has the stiffness that was stated.
    fn make_stiffness_that_of_the_tip(&mut self, offered: &mut Offered) -> anyhow::Result<()> {
        let index = self.index + 1;
        let checked = self.blueprint.check(learned::COMPONENTS)?;
        let system = checked.build();
        let axis = self.axis();
        let Some(load) = axis.components.iter().position(|c| gives(c, "force")) else {
            return Ok(());
        };
        let place = format!("axis[{index}].{}.stiffness", axis.components[load].name);
        let variable = system.variables().find(&place).and_then(|r| system.variables().get(r));
        let variable = variable.context("load-force has a stiffness")?;
        let stated = variable.si.to_si(variable.start.context("a parameter has a start")?);
        let Some(found) = self.stiffness()? else { return Ok(()) };
        let gain = stated / found;
        if gain.is_finite() && gain > 0.0 && (gain - 1.0).abs() > 1e-6 {
            let own = stated * gain;
            self.axis().components[load].set("stiffness", Value::Text(format!("{own} N/m")));
            offered.notes.push(format!(
                "the mode between force and tip has a gain of {gain:.6}: {place} is {own:.6e} N/m, so that the tip has \
                 the stiffness that was stated"
            ));
        }
        Ok(())
    }

    pub(super) fn electrical(&mut self, offered: &mut Offered) -> anyhow::Result<()> {
        let axis = self.axis();
        let Some(at) = axis.components.iter().position(|c| gives(c, "charge")) else {
            bail!("the axis has no charge");
        };
        let amplifies = |c: &ComponentBlueprint| {
            c.enabled && declaration(&c.kind).is_some_and(|d| d.stage == Stage::Amplifier)
        };
        if !axis.components[..at].iter().any(amplifies) {
            offered.notes.push(
                "the blueprint has no amplifier on this axis: voltage is the command, behind delay and converter, and charge, \
                 current and transduction refer to it; where a gain lies between it and the actuator, put an amplifier \
                 into the blueprint. An amplifier outside gives command and takes current"
                    .to_owned(),
            );
        }
        if axis.components[at].get("transduction").is_some() || offered.values.is_empty() {
            return Ok(());
        }
        // By reciprocity: what a force moves by, a voltage moves by too.
        let given = self.value("load-force", "stiffness");
        let stiffness = match (self.stiffness()?, given) {
            (Some(stiffness), _) => stiffness,
            (None, Some((value, _))) => {
                let mut copy = self.blueprint.clone();
                let mut used = self.used.to_vec();
                let mut maker = Maker {
                    blueprint: &mut copy,
                    index: self.index,
                    name: self.name,
                    values: self.values,
                    used: &mut used,
                };
                let load = ComponentBlueprint::new("load-force").value("stiffness", value);
                let [part, ..] = Port::Mechanical.parts() else { bail!("no part") };
                maker.insert(load, part)?;
                maker.blueprint.check(learned::COMPONENTS)?;
                maker.stiffness()?.context("the axis reads a force")?
            }
            (None, None) => {
                bail!("{}", self.must_be_stated(&["transduction", "stiffness"], " or "))
            }
        };
        let probe = self.probe()?;
        let (low, high) = probe.commands();
        let (at_low, at_high) = (probe.at_rest(Some(low), 0.0)?, probe.at_rest(Some(high), 0.0)?);
        let gain = (at_high.0 - at_low.0) / (at_high.1 - at_low.1);
        let transduction = stiffness * gain;
        if !transduction.is_finite() {
            bail!("{}", self.must_be_stated(&["transduction"], " and "));
        }
        let from = format!(
            "stiffness {stiffness:.6e} N/m times {gain:.6e} m/V, the static gain for commands of {low} to {high} with all \
             creep"
        );
        let axis = self.axis();
        axis.components[at].set("transduction", Value::Text(format!("{transduction} C/m")));
        axis.components[at].note.push_str(&format!("; transduction {from}"));
        let value = format!("{transduction:.6e} C/m");
        offered.values.insert("transduction", Stated { value, from });
        Ok(())
    }
}
