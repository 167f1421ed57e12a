/* What every C text of the package begins with. Portable C99; no text writes anything global. */
#ifndef MCDAS_H
#define MCDAS_H
#include <math.h>
#include <string.h>

#if defined(_WIN32)
#define PUBLIC __declspec(dllexport)
#else
#define PUBLIC __attribute__((visibility("default")))
#endif
#if defined(__GNUC__)
#define OUT_OF_LINE __attribute__((noinline)) /* seldom called from where the time is spent */
#else
#define OUT_OF_LINE
#endif
#ifdef VECTOR_MATH /* of a function declared so, glibc's libmvec has versions for whole vectors: loops call those */
#define OF_VECTORS __attribute__((simd("notinbranch"), const))
#endif
#define LESSER(a, b) ((a) < (b) ? (a) : (b))
#define GREATER(a, b) ((a) > (b) ? (a) : (b))

typedef long long whole; /* a whole number as Python hands it over: 64 bits everywhere */

#endif
