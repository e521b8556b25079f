//! Items in the order of whole numbers, of which few items share one.

/// Puts items in the order of their places; those that have the same one stay in the order in which they come. Those whose place is not
/// below `places` come last. `starts` is workspace.
pub fn put_in_places<T: Copy>(
    items: impl Iterator<Item = (usize, T)> + Clone,
    places: usize,
    starts: &mut Vec<u32>,
    ordered: &mut Vec<T>,
) {
    let Some((_, any)) = items.clone().next() else { return ordered.clear() };
    starts.clear();
    starts.resize(places + 2, 0);
    items.clone().for_each(|(place, _)| starts[place.min(places) + 1] += 1);
    (1..starts.len()).for_each(|place| starts[place] += starts[place - 1]);
    ordered.resize(starts[places + 1] as usize, any);
    for (place, item) in items {
        let start = &mut starts[place.min(places)];
        ordered[*start as usize] = item;
        *start += 1;
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// They are where a stable sort puts them, whatever was there before.
        #[test]
        fn items_come_in_the_order_of_their_places(numbers in prop::collection::vec(0_usize..40, 0..100), places in 0_usize..40) {
            let items = || numbers.iter().copied().zip(0_u32..);
            let (mut starts, mut ordered) = (vec![7; 3], vec![7; 5]);
            put_in_places(items(), places, &mut starts, &mut ordered);
            let mut expected: Vec<(usize, u32)> = items().map(|(place, item)| (place.min(places), item)).collect();
            expected.sort_by_key(|(place, _)| *place);
            prop_assert_eq!(ordered, expected.iter().map(|(_, item)| *item).collect::<Vec<_>>());
        }
    }
}
