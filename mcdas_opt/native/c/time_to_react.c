/* Until when a candidate is open, for all of them and every start at once. The numbers in capitals stand before this text. Each part builds
 * on those before it. */
#include "edges.h"
#include "time_to_react/motion.h"
#include "time_to_react/separation.h"
#include "time_to_react/predicted_traffic.h"
#include "time_to_react/questions.h"
#include "time_to_react/guess.h"
#include "time_to_react/search.h"
#include "time_to_react/answer.h"
