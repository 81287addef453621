// The contact kernels for machines with AVX-512.
#define TENDRIL_ROD_WIDTH 8
#define TENDRIL_CONTACT_KERNELS Avx512Kernels
#include "model/rods/contact_body.h"
