// The rod kernels for machines with AVX2 and FMA.
#define TENDRIL_ROD_WIDTH 4
#define TENDRIL_ROD_KERNELS Avx2Kernels
#include "model/rods/rod_lanes_body.h"
