//! Marks of objects that appeared a moment ago.

use crate::geometry::Point;

/// Marks at most this far apart belong to one object, metres: beams meet a side far ahead at every second cell.
const SAME_OBJECT_M: f64 = 0.12;

/// The places of the new marks that are not part of an object with an older mark: the sides of a box come into view one after the other.
/// Each mark has its place, and whether it is new.
pub(super) fn places_of_new_objects(marks: impl Iterator<Item = (Point, bool)>) -> Vec<Point> {
    let (mut new, mut older) = (Vec::new(), Vec::new());
    for (place, is_new) in marks {
        if is_new { &mut new } else { &mut older }.push(place);
    }
    let mut at = 0;
    while let Some(known) = older.get(at).filter(|_| !new.is_empty()).copied() {
        new.retain(|place| {
            let joins = (place - known).norm_squared() <= SAME_OBJECT_M.powi(2);
            older.extend(joins.then_some(*place));
            !joins
        });
        at += 1;
    }
    new
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn new_side_of_an_older_object_is_no_new_object() {
        let side = |y: f64, is_new: bool| {
            (0..10).map(move |step| (Point::new(0.1 * f64::from(step), y), is_new))
        };
        let person = [(Point::new(0.5, 1.0), true), (Point::new(0.55, 1.0), true)];
        let front = (0..10).map(|step| (Point::new(0.0, 0.1 * f64::from(step)), false));
        let marks: Vec<_> = side(0.0, true).chain(person).chain(front).collect();
        let expected = person.map(|(place, _)| place);
        assert_eq!(places_of_new_objects(marks.iter().copied()), expected);
        let all_new = marks.iter().map(|(place, _)| (*place, true));
        assert_eq!(places_of_new_objects(all_new).len(), marks.len());
    }
}
