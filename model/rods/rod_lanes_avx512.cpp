// The rod kernels for machines with AVX-512.
#define TENDRIL_ROD_WIDTH 8
#define TENDRIL_ROD_KERNELS Avx512Kernels
#include "model/rods/rod_lanes_body.h"
