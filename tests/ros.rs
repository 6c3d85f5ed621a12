//! ROS 2: Nav2 parameter files as settings, and the node without DDS.

mod cases {
    mod ros {
        mod messages;
        mod nav2;
        mod node_core;
    }
}
