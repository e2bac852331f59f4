//! Sorting by counting: rays that share a key are put after each other.

/// `items` in the order of their keys, which are below `keys`: counted, then each put in its place.
pub(crate) fn order<T: Copy>(items: &[T], keys: usize, key: impl Fn(&T) -> usize) -> Vec<T> {
    let mut next = vec![0_u32; keys + 1];
    for item in items {
        next[key(item) + 1] += 1;
    }
    for key in 1..next.len() {
        next[key] += next[key - 1];
    }
    let mut ordered = items.to_vec();
    for item in items {
        let place = &mut next[key(item)];
        ordered[*place as usize] = *item;
        *place += 1;
    }
    ordered
}
