/* davar - is a configuration one that the pipeline of a number type can serve? */
#ifndef DAVAR_SRC_CONFIG_H
#define DAVAR_SRC_CONFIG_H

#include "pipeline/pipelines.h"

/* DAVAR_OK or the first cause of refusal, in the order of davar_status_t. */
davar_status_t davar_config_check(const davar_config_t *config, const davar_number_t *number, bool is_float);

#endif
