// The kernel of a tag's fit for any machine.
#define TENDRIL_FIT_WIDTH 4
#define TENDRIL_FIT_KERNELS BaseKernels
#include "capture/track/tag_fit_body.h"
