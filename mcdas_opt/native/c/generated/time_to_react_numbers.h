/* Generated: the numbers of `time_to_react.compiled_case`. */
#define LANES 8
#define ROOM 104
#define PIECE 16
#define SHARE 0.98
#define SLOWEST_MPS 0.5
#define STEEPEST 0.9
#define LEAST_M 0.0001
#define GENTLE_S 0.6
#define CURVIEST_1PM 0.08
#define ROUNDS 3
#define PASSES 4
#define EDGE_M 0.01
#define ROOM_SHARE 0.95
#define NOWHERE_M 10000.0
#define STEP_REACH_M 3.0
#define BOW 0.2
#define ARRIVED_M 1.0
#define CONSTANT_STEPS 2
#define TURNED_STEPS 5
#define ABILITY_M 10.0
#define LATTICE_S 0.02
#define LEAST_ANCHORS 3
#define ANCHORS 6
#define APART_S 2.0
#define STARTS 41
#define BEST 12
#define WIDER 8
#define TRIED {5, 3, 2, 1, 0, -1, -3, -6, -10, -16, -25, -40}
#define BEST_EASY 2
#define TRIED_EASY {2, -1, -5}
#define DOWN {7, 14, 35, 90, 220}
#define UP {4, 10}
#define BETWEEN {0.25, 0.5, 0.75}
#define CLOSE 2
#define SEARCH_ROUNDS 6
#define GENTLEST 3
#define FARTHER {3, 1}
#define REFINED 8
#define IN_LANE {{0.93, 1.0, 1.0}, {1.07, 1.0, 1.0}, {1.0, 0.8, 1.0}, {1.0, 1.25, 1.0}, {0.93, 1.25, 1.0}, {1.07, 0.8, 1.0}, {0.97, 1.0, 1.0}, {1.03, 1.0, 1.0}, {1.0, 0.9, 1.0}, {1.0, 1.12, 1.0}}
#define STEERED {{1.0, 1.0, 0.94}, {1.0, 1.0, 1.05}, {0.9, 1.0, 1.0}, {1.1, 1.0, 1.0}, {1.0, 0.75, 1.0}, {1.0, 1.3, 1.0}, {1.1, 1.0, 0.94}, {0.9, 1.0, 1.05}, {1.0, 0.88, 1.0}, {1.0, 1.14, 1.0}}
#define STEADY 2
#define MOST 0.99
#define LEAST 0.12
