#pragma once
// What this machine's processor offers to kernels that are compiled for several.

namespace tendril {

// Doubles in the widest vector register that kernels use: 8 (AVX-512), 4 (AVX2 with FMA) or 2.
int MachineDoubles();

}  // namespace tendril
