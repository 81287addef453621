#include "model/machine.h"

namespace tendril {

int MachineDoubles() {
#ifdef __x86_64__
  static const int width = __builtin_cpu_supports("avx512f")                                 ? 8
                           : __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") ? 4
                                                                                             : 2;
  return width;
#else
  return 2;
#endif
}

}  // namespace tendril
