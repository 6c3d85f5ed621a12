//! People next to an emulated robot, placed in its frame.

use std::str::FromStr;

use inbye::geometry::{Point, Pose};
use inbye::map::MovingDisc;
use inbye::robot::Footprint;
use inbye::sim::{MovingObstacle, MovingObstacles, TimedPath};

/// Radius of a person, metres.
const RADIUS_M: f64 = 0.3;

/// Largest distance of a person, metres, largest speed, m/s, and longest wait, seconds.
const FARTHEST_M: f64 = 100.0;
const FASTEST_M_S: f64 = 10.0;
const LONGEST_S: f64 = 1e6;

/// A person who appears ahead of the robot, and may walk across its way once. A person does not yield.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmulatedPerson {
    /// Gap to the robot's outline in its direction of travel if the person stood on its axis, metres.
    gap_m: f64,
    /// Distance to the left of the robot's axis, metres.
    left_m: f64,
    /// Speed of the walk to the same distance on the other side, m/s, and the time until it starts, seconds.
    speed_m_s: f64,
    wait_s: f64,
    /// Time at which the person appears, seconds since power-on.
    pub from_s: f64,
}

impl EmulatedPerson {
    /// The person at the time of the appearance, with the robot at a pose.
    pub fn appear(&self, robot: &Pose, footprint: &Footprint) -> anyhow::Result<MovingObstacle> {
        let ahead_m = footprint.distance_with_gap_m(0.0, RADIUS_M, self.gap_m);
        let at = |left_m: f64| robot.transform(&Point::new(ahead_m, left_m));
        let mut keys = vec![(0.0, at(self.left_m))];
        let walk_m = 2.0 * self.left_m.abs();
        if self.speed_m_s > 0.0 && walk_m > 0.0 {
            if self.wait_s > 0.0 {
                keys.push((self.wait_s, at(self.left_m)));
            }
            keys.push((self.wait_s + walk_m / self.speed_m_s, at(-self.left_m)));
        }
        Ok(MovingObstacle::timed_path(RADIUS_M, TimedPath::new(&keys, None)?)?)
    }
}

impl FromStr for EmulatedPerson {
    type Err = String;

    /// Parses `GAP[,LEFT[,SPEED[,WAIT]]]@S`.
    fn from_str(text: &str) -> Result<Self, String> {
        let error = || {
            format!(
                "`{}` is not a person: write GAP[,LEFT[,SPEED[,WAIT]]]@S in metres, m/s and seconds, such as 1.7@9 or 3,1.2,1.2@9",
                text.escape_debug()
            )
        };
        let number = |text: &str, least: f64, most: f64| {
            let number = text.trim().parse().ok();
            number.filter(|number: &f64| (least..=most).contains(number)).ok_or_else(error)
        };
        let (place, from_s) = text.split_once('@').ok_or_else(error)?;
        let mut parts = place.split(',');
        let gap_m = number(parts.next().unwrap_or_default(), 0.0, FARTHEST_M)?;
        let mut next =
            |least: f64, most: f64| parts.next().map_or(Ok(0.0), |text| number(text, least, most));
        let person = Self {
            gap_m,
            left_m: next(-FARTHEST_M, FARTHEST_M)?,
            speed_m_s: next(0.0, FASTEST_M_S)?,
            wait_s: next(0.0, LONGEST_S)?,
            from_s: number(from_s, 0.0, LONGEST_S)?,
        };
        if parts.next().is_some() { Err(error()) } else { Ok(person) }
    }
}

/// All people of an emulation.
pub struct EmulatedPeople {
    /// Those who have not appeared yet, the next one last.
    coming: Vec<EmulatedPerson>,
    present: MovingObstacles,
    last_s: f64,
}

impl EmulatedPeople {
    pub fn new(mut people: Vec<EmulatedPerson>) -> Self {
        people.sort_by(|one, other| other.from_s.total_cmp(&one.from_s));
        Self { coming: people, present: MovingObstacles::default(), last_s: 0.0 }
    }

    /// Advances to a time, seconds, with the robot at a pose.
    pub fn step(&mut self, now_s: f64, robot: &Pose, footprint: &Footprint) -> anyhow::Result<()> {
        self.present.step(now_s - self.last_s, robot, footprint);
        self.last_s = now_s;
        while let Some(person) = self.coming.pop_if(|person| person.from_s <= now_s) {
            self.present.push(person.appear(robot, footprint)?);
        }
        Ok(())
    }

    /// The people who have appeared.
    pub fn discs(&self) -> Vec<MovingDisc> {
        self.present.discs()
    }
}

#[cfg(test)]
mod tests {
    use inbye::runtime::Config;

    use super::*;

    #[test]
    fn person_appears_with_its_gap_and_walks_to_the_other_side() {
        let footprint = Config::default().robot.footprint;
        let robot = Pose::new(3.0, 2.0, core::f64::consts::FRAC_PI_2);
        let stands: EmulatedPerson = "1.7@9".parse().expect("a person");
        let disc = stands.appear(&robot, &footprint).expect("a path").disc().expect("present");
        let gap_m = footprint.gap_to_moving_m(&robot, &disc);
        assert!((1.7..1.71).contains(&gap_m) && disc.x == 3.0, "{gap_m}: {disc:?}");
        let walks: EmulatedPerson = "3,1.2,0.8,1@9".parse().expect("a person");
        let person = walks.appear(&robot, &footprint).expect("a path");
        let mut people = MovingObstacles::new(vec![person]);
        let mut x_after = |time_s: f64| {
            people.step(time_s, &robot, &footprint);
            people.discs()[0].x
        };
        assert!((x_after(0.9) - 1.8).abs() < 1e-9);
        assert!((x_after(1.6) - 3.0).abs() < 1e-6);
        assert!((x_after(5.0) - 4.2).abs() < 1e-9);
    }

    #[test]
    fn second_person_does_not_move_the_first_one() {
        let footprint = Config::default().robot.footprint;
        let robot = Pose::default();
        let person = |text: &str| text.parse().expect("a person");
        let mut people = EmulatedPeople::new(vec![person("9,0@3"), person("3,1,1@1")]);
        let mut at = |now_s: f64| {
            people.step(now_s, &robot, &footprint).expect("a path");
            people.discs().iter().map(|disc| disc.y).collect::<Vec<_>>()
        };
        assert_eq!(at(0.5), [0.0; 0]);
        assert_eq!(at(1.0), [1.0]);
        // It has walked from 1 m left to 1 m right, and stays there.
        for now_s in [3.0, 3.1] {
            let ys = at(now_s);
            assert!(ys.len() == 2 && (ys[0] + 1.0).abs() < 1e-6 && ys[1] == 0.0, "{ys:?}");
        }
    }

    #[test]
    fn person_with_wrong_numbers_is_rejected() {
        for text in ["1.7", "@9", "x@9", "1.7@-1", "1,2,3,4,5@9", "-1@9", "1,0,-1@9", "nan@9"] {
            let error = text.parse::<EmulatedPerson>().expect_err(text);
            assert!(error.contains("is not a person"), "{error}");
        }
    }
}
