/* What generated stage functions begin with: functions that their loops over stages may call for whole vectors. */
#include "mcdas.h"

#ifdef VECTOR_MATH
double sin(double) OF_VECTORS;
double cos(double) OF_VECTORS;
double tan(double) OF_VECTORS;
double atan(double) OF_VECTORS;
double exp(double) OF_VECTORS;
double log(double) OF_VECTORS;
double tanh(double) OF_VECTORS;
#endif
