// The kernel of a tag's fit for machines with AVX2 and FMA.
#define TENDRIL_FIT_WIDTH 8
#define TENDRIL_FIT_KERNELS Avx2Kernels
#include "capture/track/tag_fit_body.h"
