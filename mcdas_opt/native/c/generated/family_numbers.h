/* Generated: the numbers of `manoeuvres.compiled_family`. */
#define USUAL_ROW 48
#define LANES 8
#define PEAK 10.392304845413264
#define LEAST_SHIFT_M 0.1
#define SPEED_FLOOR_MPS 3.0
#define NEAR_M 1.5
#define EDGE_M 0.02
#define TICK 1e-09
