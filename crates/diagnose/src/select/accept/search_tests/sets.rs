//! How a set of effects is improved: members that are replaced, and members that are dropped.

use super::*;

#[test]
fn a_member_that_is_better_replaced_is() {
    let synthetic = imitated();
    let mut rivals = marked(2);
    let best = synthetic.search().reconsider(synthetic.families(&[0, 1]), &mut rivals);
    assert_eq!(names(&best), [1, 2]);
    // Each list is of its slot and given the member that stands.
    assert_eq!((listed(&rivals[0])[0], listed(&rivals[1])[0]), (1, 2));
    assert!(!listed(&rivals[0]).contains(&2) && listed(&rivals[0]).contains(&0));
    assert!(!listed(&rivals[1]).contains(&1));
}

#[test]
fn a_last_member_that_is_replaced_has_the_others_looked_at_again() {
    let synthetic = three();
    let mut rivals = marked(3);
    let best = synthetic.search().reconsider(synthetic.families(&[0, 1, 5]), &mut rivals);
    assert_eq!(names(&best), [0, 1, 2]);
    for slot in [0, 1] {
        let given = rivals[slot].iter().filter_map(|l| l.best.as_ref());
        assert!(given.into_iter().all(|c| c.picks[1].0 == 2), "given the new one");
    }
}

#[test]
fn another_formula_of_the_last_member_is_taken() {
    let columns: [&[(usize, f64)]; 3] = [&[(3, 1.0)], &[(5, 1.0), (13, 0.3)], &[(5, 1.0)]];
    let mut synthetic = Synthetic::new(&[(3, 10.0), (5, 8.0)], &columns);
    let better = synthetic.library.pop().unwrap().formulas;
    synthetic.library[1].formulas.extend(better);
    let mut rivals = marked(2);
    let best = synthetic.search().reconsider(synthetic.families(&[0, 1]), &mut rivals);
    assert_eq!(best.picks, [(0, 0), (1, 1)]);
    // It is the same effect: the others are not looked at again.
    assert!(rivals[0].iter().filter_map(|l| l.best.as_ref()).all(|c| c.picks[0] == (1, 0)));
    assert_eq!(listed(&rivals[1])[0], 1);
}

#[test]
fn a_set_stands_where_nothing_is_better_by_more_than_one_in_rank() {
    let synthetic = three();
    let set = synthetic.families(&[0, 1, 2]);
    let reconsidered = |by: f64| {
        let set = Candidate { rank: set.rank + by, ..set.clone() };
        let mut rivals = marked(3);
        let best = synthetic.search().reconsider(set, &mut rivals);
        assert_eq!(rivals.iter().map(|list| listed(list)[0]).collect::<Vec<_>>(), names(&best));
        names(&best)
    };
    assert_eq!(reconsidered(0.0), [0, 1, 2]);
    assert_eq!(reconsidered(0.7), [0, 1, 2]);
    // The first one is found again, and stands last.
    assert_eq!(reconsidered(1.3), [1, 2, 0]);
}

#[test]
fn two_members_are_exchanged_at_most() {
    let synthetic = three();
    let best = synthetic.search().reconsider(synthetic.families(&[3, 4, 5]), &mut marked(3));
    assert_eq!(names(&best), [5, 0, 1]);
}

#[test]
fn what_goes_with_an_effect_is_what_comes_back_without_it() {
    let synthetic =
        Synthetic::new(&[(3, 10.0), (5, 8.0)], &[&[(3, 1.0)], &[(5, 1.0)], &[(7, 1.0)]]);
    let (search, base) = (synthetic.search(), synthetic.retuned());
    let alone = |families: &[usize]| search.alone(&base, &synthetic.families(families));
    assert!(alone(&[]).is_empty());
    let [first] = alone(&[0])[..] else { panic!("one") };
    close(first, 100.0 / 164.0, 0.03);
    let [first, second, useless] = alone(&[0, 1, 2])[..] else { panic!("three") };
    close(first, 100.0 / 164.0, 0.03);
    close(second, 64.0 / 164.0, 0.03);
    close(useless, 0.0, 1e-3);
    assert!(useless >= 0.0);
}

#[test]
fn what_the_others_can_do_without_is_dropped() {
    let synthetic = Synthetic::new(
        &[(3, 10.0), (5, 8.0)],
        &[&[(3, 1.0)], &[(5, 1.0)], &[(7, 1.0)], &[(9, 1.0)]],
    );
    let (search, base) = (synthetic.search(), synthetic.retuned());
    let eliminated = |families: &[usize]| {
        let mut rivals = marked(families.len());
        let best = search.eliminate(&base, synthetic.families(families), &mut rivals);
        (names(&best), marks(&rivals))
    };
    assert_eq!(eliminated(&[0, 1]), (vec![0, 1], vec![0, 1]));
    assert_eq!(eliminated(&[0, 1, 2]), (vec![0, 1], vec![0, 1]));
    assert_eq!(eliminated(&[2, 0, 3, 1]), (vec![0, 1], vec![1, 3]));
    // The last one is not eliminated, whatever it is worth: that is for others to say.
    assert_eq!(eliminated(&[2]), (vec![2], vec![0]));
    assert_eq!(eliminated(&[2, 3]).0.len(), 1);
}

#[test]
fn what_is_small_and_alone_in_its_bands_is_not_dropped() {
    // 9 powers of the noise beside 900.
    let synthetic = Synthetic::new(&[(3, 30.0), (15, 3.0)], &[&[(3, 1.0)], &[(15, 1.0)]]);
    let (search, base) = (synthetic.search(), synthetic.retuned());
    let pair = synthetic.families(&[0, 1]);
    let alone = search.alone(&base, &pair);
    assert!(alone[1] < Thresholds::DROPPED, "{alone:?}");
    let best = search.eliminate(&base, pair, &mut marked(2));
    assert_eq!(names(&best), [0, 1]);
}
