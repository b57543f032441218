/* davar tests - a storage of two slots in RAM. Define SLOT, the bytes of a slot, before. */
#ifndef DAVAR_TESTS_CELLS_H
#define DAVAR_TESTS_CELLS_H

#include "davar/state.h"

#include <string.h>

static unsigned char cells[2U * SLOT];

static bool read_cells(void *context, size_t offset, void *data, size_t bytes)
{
    (void)context;
    memcpy(data, &cells[offset], bytes);
    return true;
}

static bool write_cells(void *context, size_t offset, const void *data, size_t bytes)
{
    (void)context;
    memcpy(&cells[offset], data, bytes);
    return true;
}

static const davar_storage_t storage = {read_cells, write_cells, NULL, SLOT};

#endif
