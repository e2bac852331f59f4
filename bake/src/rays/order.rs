//! Sorting by counting: items with the same key are put after each other.

/// Sorts `items` by their keys, which are below `keys`, at most 2^32.
///
/// It counts the items of each key and then puts every item in its place. Items with the same key
/// stay in their order.
pub(crate) fn order<T: Copy>(items: &[T], keys: usize, key: impl Fn(&T) -> usize) -> Vec<T> {
    let keys_of_items: Vec<u32> = items.iter().map(|item| key(item) as u32).collect();
    let mut next = vec![0_u32; keys + 1];
    for &key in &keys_of_items {
        next[key as usize + 1] += 1;
    }
    for key in 1..next.len() {
        next[key] += next[key - 1];
    }
    let mut ordered = items.to_vec();
    for (item, key) in items.iter().zip(keys_of_items) {
        let place = &mut next[key as usize];
        ordered[*place as usize] = *item;
        *place += 1;
    }
    ordered
}
