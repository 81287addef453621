// The rod kernels for any machine.
#define TENDRIL_ROD_WIDTH 2
#define TENDRIL_ROD_KERNELS BaseKernels
#include "model/rods/rod_lanes_body.h"
