/* davar-sim - windows around the epoch, with mirrored ends. They need samples from after the epoch,
 * so only a host computes them; devices compute trailing windows. One instance per channel, used
 * like one of the library (davar/davar.h), with the same arithmetic. */
#ifndef CENTRED_H
#define CENTRED_H

#include "davar/types.h"
#include "davar_port.h"

typedef struct centred centred_t;

/* An instance with a configuration that davar_init_* of this number type accepts, of even lengths,
 * steps of 0 or 2, and no law with a queue (settings_make checks it). It must outlive the instance.
 * Null: out of memory. Memory: 12 bytes for each sample of window and stride. */
centred_t *centred_open(const davar_config_t *config, davar_port_number_t number);

/* Takes samples from samples[from] to samples[count - 1], up to the one that completes a result.
 * Returns how many. Cost: O(T) per sample, T cluster sizes. */
size_t centred_push(centred_t *centred, davar_port_samples_t samples, size_t from, size_t count);

/* Reports `missing` lost samples before the next one. */
void centred_gap(centred_t *centred, uint32_t missing);

/* The next result after the last sample, from the mirrored end. False: none is left, or the record
 * is shorter than half of the longest window. */
bool centred_flush(centred_t *centred);

/* The newest result, once. Intervals and coefficients are absent. */
bool centred_take(centred_t *centred, davar_result_t *result);

davar_health_t centred_health(const centred_t *centred);

/* Allowed with null. */
void centred_close(centred_t *centred);

#endif
