//! Programs that write more lines than they are asked for, and answers with the number of their message.

use std::fs;

use serde_json::{Value, json};

use super::own_programs::{STATE, driven, script, text};
use super::program::Workplace;

/// A script with a surplus line at its message 5: inbye has sent that message, and takes the line as the answer to it. The command
/// `answer` answers message `$t`.
fn surplus(place: &Workplace, name: &str, answer: &str) {
    let each = [
        "t=${t:-0}; if [ $t = 5 ]",
        &format!("then t=4; {answer}; t=5"),
        // The next message comes meanwhile: no line is there before it.
        &format!("fi; sleep 0.03; {answer}; t=$((t + 1))"),
    ];
    script(place, name, &each.join("; "));
}

const VELOCITY: &str = r#"echo '{"linear": 0.5, "angular": 0}'"#;
const NUMBERED: &str = r#"printf '{"tick": %d, "linear": 0.5, "angular": 0}\n' $t"#;

#[test]
fn controller_whose_answers_are_one_message_late_fails() {
    let place = Workplace::with_room();
    for (answer, expected) in [
        (VELOCITY, "INVALID_CONTROLLER: a script: wrote a second line for one message: `{"),
        (NUMBERED, "it is for message 4, and message 5 was asked: write one line for each"),
    ] {
        surplus(&place, "late.sh", answer);
        let (status, object) = driven(&place, "--controller 'sh late.sh'");
        assert_eq!((status, &object["reached"]), (1, &json!(false)), "{object}");
        assert!(text(&object, "fault").contains(expected), "{object}");
    }
}

#[test]
fn answers_may_have_the_number_of_their_message_and_a_farewell_is_no_answer() {
    let place = Workplace::with_room();
    let answer = format!("t=${{t:-0}}; {NUMBERED}; t=$((t + 1))");
    script(&place, "numbered.sh", &answer);
    let whole = fs::read_to_string(place.path("numbered.sh")).expect("the script");
    place.write("farewell.sh", whole + "echo farewell\n");
    for program in ["numbered.sh", "farewell.sh"] {
        let (status, object) = driven(&place, &format!("--controller 'sh {program}'"));
        assert_eq!((status, &object["reached"]), (0, &json!(true)), "{program}: {object}");
    }
}

/// The answer to the last message is late: it is no surplus line.
#[test]
fn answer_that_is_due_at_the_end_is_no_surplus_line() {
    let place = Workplace::with_room();
    script(&place, "slow.sh", &format!("sleep 0.1; {VELOCITY}"));
    let more = "--controller 'sh slow.sh' --deadline 20 --time-limit 1";
    let (status, object) = driven(&place, more);
    assert_eq!((status, &object["fault"]), (1, &Value::Null), "{object}");
}

#[test]
fn surplus_line_of_a_global_planner_fails_the_mission() {
    let place = Workplace::with_room();
    // Both lines in one write: the second is there before the next message, also on a busy machine.
    let path = r#"{"path": [[1, 1.5], [3, 2.5], [5, 1.5]]}\n"#;
    script(&place, "plans.sh", &format!("printf '{path}{path}'"));
    let (status, object) = driven(&place, "--global-planner 'sh plans.sh'");
    assert_eq!((status, &object["reached"]), (1, &json!(false)), "{object}");
    let expected = "INVALID_PLANNER: a script: wrote a second line for one message";
    assert!(text(&object, "fault").contains(expected), "{object}");
}

#[test]
fn surplus_line_of_a_simulator_ends_the_drive_as_its_failure() {
    let place = Workplace::with_room();
    place.write("state.json", format!("{STATE}\n"));
    surplus(&place, "stands.sh", "cat state.json");
    let (status, object) = driven(&place, "--simulator 'sh stands.sh' --time-limit 2");
    let why = text(&object, "why");
    let expected = "the simulator failed: wrote a second line for one message";
    assert!(status == 1 && why.contains(expected), "{why}");
}
