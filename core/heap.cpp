#include "core/heap.h"

#include <malloc.h>

namespace pleat {

void give_large_blocks_back() { mallopt(M_MMAP_THRESHOLD, 4 << 20); }

}  // namespace pleat
