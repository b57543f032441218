/* davar - the grid as an engine of the number type q31. */
#include "number/q31.inc"

#include "number/q31_runs.inc"

#include "core/engine.h"
#include "core/instance.h"
#include "core/window.h"

#define GRID_NUMBER davar_number_q31
#define GRID_ENGINE davar_engine_grid_q31

/* clang-format off */
#include "core/allan.inc"
#include "engines/grid.inc"
