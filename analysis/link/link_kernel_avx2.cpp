#define TENDRIL_LINK_WIDTH 4
#include "analysis/link/link_kernel_body.h"

namespace tendril::link_kernel {

void RunAvx2(Job& job) { Run(job); }

}  // namespace tendril::link_kernel
