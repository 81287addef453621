#define TENDRIL_LINK_WIDTH 8
#include "analysis/link/link_kernel_body.h"

namespace tendril::link_kernel {

void RunAvx512(Job& job) { Run(job); }

}  // namespace tendril::link_kernel
