// Which rows of the manifest are this process's, as the engine that started it says.
#pragma once

namespace pleat::campaign {

// Rows index, index + count, ... of the manifest.
struct TaskSlice {
  int index = 0, count = 1;
};

// Both from flags; -1 stands for one not given. Where none is, the first of these that is set:
//   SLURM_ARRAY_TASK_ID, _MIN, _COUNT      Slurm array jobs
//   JOB_COMPLETION_INDEX, PLEAT_TASK_COUNT Kubernetes Indexed Jobs
//   PARALLEL_SEQ, PLEAT_TASK_COUNT         GNU parallel
// else all rows. InputError where they do not fit together.
TaskSlice task_slice(int index, int count);

}  // namespace pleat::campaign
