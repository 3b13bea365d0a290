//! Past commands and past outputs.
//!
//! ```text
//! z(t) = [u(t), u(t−1), …, u(t−m), y(t−1), …, y(t−n)]
//! ```

/// Orders m and n. P0: m = n = N_h; P1's comparison: m = n = 3.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Narx {
    /// Past commands m.
    pub commands: usize,
    /// Past outputs n.
    pub outputs: usize,
}

impl Narx {
    pub(super) fn dimension(&self) -> usize {
        1 + self.commands + self.outputs
    }

    pub(super) fn memory(&self) -> usize {
        self.commands + self.outputs
    }

    pub(super) fn rest(&self, u: f64, y: f64, memory: &mut [f64]) {
        let (commands, outputs) = memory.split_at_mut(self.commands.min(memory.len()));
        commands.fill(u);
        outputs.fill(y);
    }

    pub(super) fn step(&self, u: f64, memory: &mut [f64], z: &mut [f64]) {
        let Some((first, rest)) = z.split_first_mut() else { return };
        *first = u;
        rest.iter_mut().zip(memory.iter()).for_each(|(z, m)| *z = *m);
        let commands = self.commands.min(memory.len());
        super::push(&mut memory[..commands], u);
    }

    pub(super) fn output(&self, y: f64, memory: &mut [f64]) {
        let commands = self.commands.min(memory.len());
        let outputs = self.outputs.min(memory.len() - commands);
        super::push(&mut memory[commands..commands + outputs], y);
    }
}

#[cfg(test)]
mod tests {
    use super::super::Features;
    use super::*;

    #[test]
    fn inputs_are_in_the_paper_s_order() {
        let narx = Features::Narx(Narx { commands: 2, outputs: 1 });
        let all = narx.of_record(&[1.0, 2.0, 3.0], &[10.0, 20.0, 30.0]);
        assert_eq!(all, [1.0, 1.0, 1.0, 10.0, 2.0, 1.0, 1.0, 10.0, 3.0, 2.0, 1.0, 20.0]);
        let without = Features::Narx(Narx { commands: 0, outputs: 0 });
        assert_eq!(without.of_record(&[1.0, 2.0], &[0.0, 0.0]), [1.0, 2.0]);
    }
}
