//! Messages and services of managed nodes.

use super::declaration::messages;

messages! {
    /// A state of a managed node.
    #[derive(Default, Eq)]
    lifecycle_msgs / State {
        /// Number of the state.
        id: u8,
        /// Its name.
        label: String,
    }

    /// A transition between states.
    #[derive(Default, Eq)]
    lifecycle_msgs / Transition {
        /// Number of the transition.
        id: u8,
        /// Its name.
        label: String,
    }

    /// A transition with its states.
    #[derive(Default, Eq)]
    lifecycle_msgs / TransitionDescription {
        /// The transition.
        transition: Transition,
        /// State before it.
        start_state: State,
        /// State after it.
        goal_state: State,
    }

    /// A transition that has taken place.
    #[derive(Default, Eq)]
    lifecycle_msgs / TransitionEvent {
        /// Time of the transition, nanoseconds since 1970.
        timestamp: u64,
        /// The transition.
        transition: Transition,
        /// State before it.
        start_state: State,
        /// State after it.
        goal_state: State,
    }

    /// A request to change the state.
    #[derive(Default, Eq)]
    lifecycle_msgs / ChangeStateRequest {
        /// The transition; where its number is zero, its name counts.
        transition: Transition,
    }

    /// Whether the state was changed.
    #[derive(Copy, Default, Eq)]
    lifecycle_msgs / ChangeStateResponse {
        /// Whether it was.
        success: bool,
    }

    /// A request without content: a member that every structure needs.
    #[derive(Copy, Default, Eq)]
    lifecycle_msgs / EmptyRequest {
        /// Not used.
        structure_needs_at_least_one_member: u8,
    }

    /// The present state.
    #[derive(Default, Eq)]
    lifecycle_msgs / GetStateResponse {
        /// The state.
        current_state: State,
    }

    /// The transitions from the present state.
    #[derive(Default, Eq)]
    lifecycle_msgs / GetAvailableTransitionsResponse {
        /// The transitions.
        available_transitions: Vec<TransitionDescription>,
    }

    /// A request to change the state, between the processes of the node.
    #[derive(Copy, Eq)]
    inbye_msgs / LifecycleRequest {
        /// Number of the request.
        request: u64,
        /// Number of the transition.
        transition: u8,
    }

    /// The state after a request, or without one, between the processes of the node.
    #[derive(Copy, Eq)]
    inbye_msgs / LifecycleAnswer {
        /// Number of the request; zero for none.
        request: u64,
        /// Number of the transition that took place; zero for none.
        transition: u8,
        /// Number of the state.
        state: u8,
        /// Time of the transition, nanoseconds since 1970.
        nanoseconds: u64,
    }
}
