//! One question at a time: how long an answer is waited for, and how often it is asked again.

/// How patient a session is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Patience {
    /// Time until a question counts as lost, seconds.
    pub answer_within_s: f64,
    /// How often it is asked in all.
    pub tries: u32,
}

/// The question under way, if any.
#[derive(Clone, Debug)]
pub(super) struct Exchange<Q> {
    patience: Patience,
    under_way: Option<UnderWay<Q>>,
}

#[derive(Clone, Debug)]
struct UnderWay<Q> {
    question: Q,
    asked_s: f64,
    tries_left: u32,
}

/// What the time says about the question under way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Turn<Q> {
    /// Nothing is under way.
    Free,
    /// Its answer is not due yet.
    Wait,
    /// It is to be asked again.
    Again(Q),
    /// It was asked often enough, and is forgotten.
    GivenUp(Q),
}

impl<Q: Copy> Exchange<Q> {
    pub(super) const fn new(patience: Patience) -> Self {
        Self {
            patience,
            under_way: None,
        }
    }

    /// Starts a question.
    pub(super) fn ask(&mut self, question: Q, now_s: f64) {
        self.under_way = Some(UnderWay {
            question,
            asked_s: now_s,
            tries_left: self.patience.tries - 1,
        });
    }

    /// The question whose answer is waited for.
    pub(super) fn question(&self) -> Option<Q> {
        self.under_way.as_ref().map(|under_way| under_way.question)
    }

    /// Ends the question: its answer came.
    pub(super) fn settle(&mut self) {
        self.under_way = None;
    }

    /// What is to be done now.
    pub(super) fn turn(&mut self, now_s: f64) -> Turn<Q> {
        let Some(under_way) = &mut self.under_way else {
            return Turn::Free;
        };
        if now_s - under_way.asked_s < self.patience.answer_within_s {
            return Turn::Wait;
        }
        let question = under_way.question;
        if under_way.tries_left == 0 {
            self.under_way = None;
            return Turn::GivenUp(question);
        }
        under_way.tries_left -= 1;
        under_way.asked_s = now_s;
        Turn::Again(question)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_question_is_asked_so_often_and_then_given_up() {
        let mut exchange = Exchange::new(Patience {
            answer_within_s: 0.01,
            tries: 3,
        });
        assert_eq!(exchange.turn(0.0), Turn::Free);
        exchange.ask('q', 0.0);
        let turns = [0.005, 0.010, 0.015, 0.021, 0.025, 0.032, 0.04];
        let turns = turns.map(|now_s| exchange.turn(now_s));
        let again = Turn::Again('q');
        let expected = [
            Turn::Wait,
            again,
            Turn::Wait,
            again,
            Turn::Wait,
            Turn::GivenUp('q'),
            Turn::Free,
        ];
        assert_eq!(turns, expected);
    }

    #[test]
    fn an_answer_ends_the_waiting() {
        let mut exchange = Exchange::new(Patience {
            answer_within_s: 0.01,
            tries: 3,
        });
        exchange.ask(1, 0.0);
        assert_eq!(exchange.question(), Some(1));
        exchange.settle();
        assert_eq!(exchange.turn(1.0), Turn::Free);
    }
}
