// The kernel of a tag's fit for machines with AVX-512.
#define TENDRIL_FIT_WIDTH 16
#define TENDRIL_FIT_KERNELS Avx512Kernels
#include "capture/track/tag_fit_body.h"
