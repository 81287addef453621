#define TENDRIL_LINK_WIDTH 2
#include "analysis/link/link_kernel_body.h"

namespace tendril::link_kernel {

void RunBase(Job& job) { Run(job); }

}  // namespace tendril::link_kernel
