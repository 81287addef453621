// The contact kernels for machines with AVX2 and FMA.
#define TENDRIL_ROD_WIDTH 4
#define TENDRIL_CONTACT_KERNELS Avx2Kernels
#include "model/rods/contact_body.h"
