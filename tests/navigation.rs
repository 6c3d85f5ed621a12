//! What the navigator is made of: localisation, tracking of moving obstacles, deadlines, odometry.

mod support {
    pub mod carried;
}

mod cases {
    mod navigation {
        mod boundaries;
        mod corridor;
        mod deadlines;
        mod footprint;
        mod goal_changes;
        mod goals_in_passages;
        mod goals_near_walls;
        mod half_circle_lidar;
        mod identification;
        mod localization;
        mod moving_obstacles;
        mod narrow_passages;
        mod observations;
        mod odometry;
        mod open_ground;
        mod operator;
        mod robot;
        mod slow_planner;
        mod surroundings;
        mod tracking;
        mod two_roadways;
        mod ways_around;
    }
}
