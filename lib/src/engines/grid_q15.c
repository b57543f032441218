/* davar - the grid as an engine of the number type q15. */
#include "number/q15.inc"

#include "number/q15_runs.inc"

#include "core/engine.h"
#include "core/instance.h"
#include "core/window.h"

#define GRID_NUMBER davar_number_q15
#define GRID_ENGINE davar_engine_grid_q15

/* clang-format off */
#include "core/allan.inc"
#include "engines/grid.inc"
