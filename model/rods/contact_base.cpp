// The contact kernels for any machine.
#define TENDRIL_ROD_WIDTH 2
#define TENDRIL_CONTACT_KERNELS BaseKernels
#include "model/rods/contact_body.h"
