//! The cases, as one table of families.

use gap_machines::{Effect, Formula, Order, Random, Setting, Wish};

use crate::error::Error;
use crate::families::{Content, FAMILIES, Family};

/// Sizes of a single effect, over the noise.
pub const SIZES: [f64; 3] = [2.0, 6.0, 20.0];

/// Sizes of a faint effect, over the noise.
const FAINT: [f64; 3] = [0.5, 1.0, 2.0];

/// What the diagnosis is told about the noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoiseHint {
    /// The standard deviation of the noise, off by this factor.
    Given(f64),
    /// A record at rest.
    Rest,
    /// Nothing.
    Nothing,
}

/// One machine and one question.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// A name that says nothing.
    pub id: String,
    /// Name of its family.
    pub family: &'static str,
    /// What is asked of the generator.
    pub order: Order,
    /// Whether the model is an FMU.
    pub is_black_box: bool,
    /// Whether the model is identified from one log.
    pub is_identified: bool,
    /// Candidates that are taken out of the library.
    pub without: Vec<String>,
    /// What is said about the noise.
    pub noise: NoiseHint,
}

/// Which benchmark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Everything random follows from it.
    pub seed: u64,
    /// Whether it is the short form: fewer cases, shorter records.
    pub is_short: bool,
}

impl Plan {
    /// All cases in a random order, so that the first of them are a fair sample.
    #[must_use]
    pub fn cases(&self) -> Vec<Case> {
        let mut all = Vec::new();
        for (number, family) in FAMILIES.iter().enumerate() {
            let count = if self.is_short { family.short } else { family.full };
            all.extend((0..count).map(|index| self.case(family, number, index)));
        }
        let mut random = Random::new(self.seed, &[1]);
        for last in (1..all.len()).rev() {
            all.swap(last, random.below(last + 1));
        }
        all
    }

    fn case(&self, family: &Family, number: usize, index: usize) -> Case {
        let mut random = Random::new(self.seed, &[2, number as u64, index as u64]);
        let id = format!("{:08x}", random.next_u64() >> 32);
        let (effects, wrong_weights, is_linear) =
            self.content((family, number), index, &mut random);
        let is_removed = family.content == Content::Removed;
        let without = effects
            .iter()
            .filter(|_| is_removed)
            .map(|wish| wish.effect.name().to_owned())
            .collect();
        let is_apart = family.content == Content::Apart;
        let noise = match if is_apart { 0 } else { random.below(3) } {
            0 => NoiseHint::Given(random.between(0.95, 1.05)),
            1 => NoiseHint::Rest,
            _ => NoiseHint::Nothing,
        };
        let is_long = family.content == Content::Long;
        let fast = is_long || (!self.is_short && random.unit() < 0.1);
        let length = match (family.content, self.is_short) {
            (Content::Long, _) => 1.75,
            (Content::Faint, _) => 0.2,
            (_, true) => 0.4,
            (_, false) => 1.0,
        };
        let order = Order {
            seed: random.next_u64(),
            effects,
            setting: family.setting,
            rate: if fast { 10_000.0 } else { 4000.0 },
            length,
            is_linear,
            wrong_weights,
            axes: family.axes,
            offset: family.offset,
            timing: family.timing,
            smooth: if family.is_smooth { random.between(0.01, 0.05).sqrt() } else { 0.0 },
        };
        let Family { name, is_black_box, is_identified, .. } = *family;
        Case { id, family: name, order, is_black_box, is_identified, without, noise }
    }

    /// Effects, error of the weights, and whether the model is a straight line.
    fn content(
        &self,
        (family, number): (&Family, usize),
        index: usize,
        random: &mut Random,
    ) -> (Vec<Wish>, f64, bool) {
        // The short form cannot have every effect in every family: each family begins elsewhere and
        // takes every other one.
        let turn = |effects: &[Effect], sizes: &[f64]| match self.is_short {
            true => wish(effects, 7 * number + 2 * index, index + number, sizes),
            false => wish(effects, index, 0, sizes),
        };
        match family.content {
            Content::None => (Vec::new(), 0.0, false),
            Content::NoneLinear => (Vec::new(), 0.0, true),
            Content::Single | Content::Removed | Content::Long => {
                (vec![turn(&listed(family.setting), &SIZES)], 0.0, false)
            }
            Content::Faint => {
                let alike: Vec<_> = all_where(|effect| effect.group().is_some());
                (vec![turn(&alike, &FAINT)], 0.0, false)
            }
            Content::Inside => {
                let inside = [Effect::Asymmetry, Effect::RateDependence, Effect::Friction];
                (vec![turn(&inside, &SIZES)], 0.0, false)
            }
            Content::Apart => {
                let apart: Vec<_> = all_where(|effect| effect.is_apart());
                (vec![turn(&apart, &SIZES)], 0.0, false)
            }
            Content::Stray => {
                let stray = all_where(Effect::is_stray);
                (vec![turn(&stray, &SIZES)], 0.0, false)
            }
            Content::Several(count) => (several(count, index, random), 0.0, false),
            Content::WrongWeights => (Vec::new(), 0.3, false),
            Content::WrongWeightsAndSingle => {
                let others = all_where(|e| is_listed(e) && e != Effect::Hysteresis);
                (vec![turn(&others, &SIZES[1..])], 0.3, false)
            }
            Content::NoHysteresis => {
                let size = SIZES[index % SIZES.len()];
                let formula = formula(index / SIZES.len());
                (vec![Wish { effect: Effect::Hysteresis, formula, size }], 0.0, true)
            }
        }
    }
}

/// Effects in turn, then sizes, then formulas; `shift` moves size and formula on.
fn wish(effects: &[Effect], index: usize, shift: usize, sizes: &[f64]) -> Wish {
    let (at, round) = (index % effects.len(), index / effects.len());
    let size = sizes[(round + shift / 2) % sizes.len()];
    Wish { effect: effects[at], formula: formula(at + round / sizes.len() + shift), size }
}

fn formula(number: usize) -> Formula {
    if number.is_multiple_of(2) { Formula::Other } else { Formula::Standard }
}

fn is_listed(effect: Effect) -> bool {
    !effect.is_stray() && !effect.is_apart()
}

fn all_where(keep: impl Fn(Effect) -> bool) -> Vec<Effect> {
    Effect::ALL.iter().copied().filter(|effect| keep(*effect)).collect()
}

fn listed(setting: Setting) -> Vec<Effect> {
    let is_loop = setting == Setting::ClosedLoop;
    all_where(|effect| is_listed(effect) && !(is_loop && effect.is_open_loop_only()))
}

/// Different effects, all of the same kind of formula.
fn several(count: usize, index: usize, random: &mut Random) -> Vec<Wish> {
    let mut left = listed(Setting::OpenLoop);
    let formula = formula(index);
    let mut wishes = Vec::new();
    while wishes.len() < count && !left.is_empty() {
        let effect = left.swap_remove(random.below(left.len()));
        let size = SIZES[1 + random.below(2)];
        // Two of one group are one answer; a pair shall be two.
        let is_new =
            |wish: &Wish| effect.group().is_none() || wish.effect.group() != effect.group();
        if wishes.iter().all(is_new) {
            wishes.push(Wish { effect, formula, size });
        }
    }
    wishes
}

/// The cases that a text such as `200`, `single,none`, `pair:20`, `single/creep:6` (those of a family in
/// which this effect is withheld) or `8c6a1eda` (the one with this name) asks for.
///
/// # Errors
/// A family, an effect or a case that there is not, or a count that is none.
pub fn select(cases: Vec<Case>, text: Option<&str>) -> Result<Vec<Case>, Error> {
    /// Cases of a family, and of an effect of it where one is given.
    struct Limit<'a> {
        family: &'a str,
        effect: Option<Effect>,
        wanted: Option<usize>,
        taken: usize,
    }
    let Some(text) = text else { return Ok(cases) };
    let refuse = |message: String| Error::Selection { text: text.to_owned(), message };
    let mut limits: Vec<Limit> = Vec::new();
    let mut total: Option<usize> = None;
    let mut names: Vec<&str> = Vec::new();
    for item in text.split(',').map(str::trim) {
        if cases.iter().any(|case| case.id == item) {
            names.push(item);
            continue;
        }
        let (name, count) = item.split_once(':').map_or((item, None), |(n, c)| (n, Some(c)));
        let number = |digits: &str| {
            digits.parse::<usize>().map_err(|_| {
                let names: Vec<_> = FAMILIES.iter().map(|family| family.name).collect();
                refuse(format!(
                    "\"{digits}\" is neither a number nor a family, nor a case of this seed; write a number \
                     of cases, or families with or without a number, as in pair:20; families are {}",
                    names.join(", ")
                ))
            })
        };
        let (family, effect) = name.split_once('/').map_or((name, None), |(f, e)| (f, Some(e)));
        if FAMILIES.iter().any(|known| known.name == family) {
            let known = |name: &str| {
                Effect::find(name).ok_or_else(|| {
                    let names: Vec<_> = Effect::ALL.iter().map(|effect| effect.name()).collect();
                    refuse(format!("\"{name}\" is no effect; write one of {}", names.join(", ")))
                })
            };
            let effect = effect.map(known).transpose()?;
            let wanted = count.map(number).transpose()?;
            limits.push(Limit { family, effect, wanted, taken: 0 });
        } else {
            let most = number(item)?;
            total = Some(total.map_or(most, |total| total.min(most)));
        }
    }
    let is_choice = !names.is_empty() || !limits.is_empty();
    if let Some(total) = total.filter(|total| *total > cases.len()) {
        return Err(refuse(format!("there are {} cases, not {total}; ask for fewer", cases.len())));
    }
    let mut kept = Vec::new();
    for case in cases {
        let takes = |limit: &&mut Limit| {
            let has = |effect| case.order.effects.iter().any(|wish| wish.effect == effect);
            limit.wanted.is_none_or(|wanted| limit.taken < wanted)
                && limit.family == case.family
                && limit.effect.is_none_or(has)
        };
        let wanted = names.contains(&case.id.as_str())
            || match limits.iter_mut().find(takes) {
                Some(limit) => {
                    limit.taken += 1;
                    true
                }
                None => !is_choice,
            };
        if wanted && kept.len() < total.unwrap_or(usize::MAX) {
            kept.push(case);
        }
    }
    // A total takes fewer of a family on purpose.
    for Limit { family, effect, wanted, taken } in limits {
        if let Some(wanted) = wanted.filter(|wanted| total.is_none() && taken < *wanted) {
            let of = effect.map_or_else(String::new, |effect| format!(" with {}", effect.name()));
            return Err(refuse(format!(
                "there are {taken} cases of {family}{of}, not {wanted}; ask for fewer, and for others with \
                 another --seed"
            )));
        }
    }
    Ok(kept)
}

#[cfg(test)]
mod tests {
    use std::collections::{BTreeMap, BTreeSet};

    use super::*;
    use crate::families::is_ambiguous;

    const FULL: Plan = Plan { seed: 1, is_short: false };

    #[test]
    fn the_full_benchmark_has_the_counts_that_its_figures_need() {
        let cases = FULL.cases();
        let none =
            cases.iter().filter(|c| c.order.effects.is_empty() && c.order.wrong_weights == 0.0);
        assert!(none.count() >= 500);
        let mut per: BTreeMap<(&str, u64), [usize; 2]> = BTreeMap::new();
        for case in cases.iter().filter(|c| c.family == "single") {
            let wish = case.order.effects[0];
            let key = (wish.effect.name(), wish.size as u64);
            per.entry(key).or_default()[usize::from(wish.formula == Formula::Other)] += 1;
        }
        assert_eq!(per.len(), 26 * 3);
        for (key, [standard, other]) in per {
            assert!(standard + other >= 30 && other >= standard, "{key:?}: {standard} {other}");
        }
    }

    #[test]
    fn names_say_nothing_and_are_unique() {
        let cases = FULL.cases();
        let ids: BTreeSet<_> = cases.iter().map(|case| case.id.as_str()).collect();
        assert_eq!(ids.len(), cases.len());
        assert_ne!(cases[0].id, Plan { seed: 2, ..FULL }.cases()[0].id);
        assert_eq!(cases, FULL.cases());
    }

    #[test]
    fn the_removed_candidate_is_the_effects_own() {
        for case in FULL.cases() {
            let own: Vec<_> =
                case.order.effects.iter().map(|w| w.effect.name().to_owned()).collect();
            let expected = if case.family == "removed" { own } else { Vec::new() };
            assert_eq!(case.without, expected);
        }
    }

    #[test]
    fn the_short_form_has_many_effects_sizes_and_both_formulas() {
        let mut cases = Plan { seed: 1, is_short: true }.cases();
        // Faint effects have sizes of their own.
        cases.retain(|case| !is_ambiguous(case.family));
        let wishes: Vec<Wish> = cases.iter().flat_map(|c| c.order.effects.clone()).collect();
        let effects: BTreeSet<_> = wishes.iter().map(|wish| wish.effect).collect();
        let sizes: BTreeSet<_> = wishes.iter().map(|wish| wish.size as u64).collect();
        let other = wishes.iter().filter(|wish| wish.formula == Formula::Other).count();
        assert!(effects.len() >= 18 && sizes.len() == 3, "{effects:?} {sizes:?}");
        assert!(2 * other >= wishes.len() && other < wishes.len(), "{other} of {}", wishes.len());
    }

    #[test]
    fn selections_take_numbers_and_families() {
        let count = |text| select(FULL.cases(), Some(text)).map(|cases| cases.len());
        assert_eq!(count("200").unwrap(), 200);
        assert_eq!(count("pair:20").unwrap(), 20);
        assert_eq!(count("pair:20,none").unwrap(), 270);
        assert_eq!(count("pair:20, none,30").unwrap(), 30);
        let message = count("pears").unwrap_err().to_string();
        assert!(message.contains("pears") && message.contains("wrong-hysteresis"), "{message}");
        assert!(count("pair:x").is_err());
        let message = count("pair:20,long:30").unwrap_err().to_string();
        assert!(message.contains("4 cases of long, not 30"), "{message}");
        assert_eq!(count("single/creep:6,pair:2").unwrap(), 8);
        let last = FULL.cases().last().map(|case| case.id.clone()).unwrap();
        assert_eq!(select(FULL.cases(), Some(&last)).unwrap()[0].id, last);
        let more = select(FULL.cases(), Some(&format!("{last},none:3"))).unwrap();
        assert_eq!(more.len(), 4);
        assert!(count("00000000:x").is_err());
        let creep = select(FULL.cases(), Some("single/creep")).unwrap();
        assert!(creep.len() >= 90);
        assert!(creep.iter().all(|case| case.order.effects[0].effect == Effect::Creep));
        let message = count("single/creeps").unwrap_err().to_string();
        assert!(message.contains("creeps") && message.contains("dac_quantisation"), "{message}");
        // A smaller sample is the start of a larger one.
        let first = select(FULL.cases(), Some("50")).unwrap();
        assert_eq!(first[..], select(FULL.cases(), Some("60")).unwrap()[..50]);
    }
}
