/* davar-node - the values of the command line. */
#ifndef NODE_SETTINGS_H
#define NODE_SETTINGS_H

#include "davar/davar.h"
#include "davar_bandwidth.h"
#include "davar_curve.h"
#include "davar_link.h"

typedef struct {
    const char *source;
    const char *out;
    const char *edges; /* null: samples arrive as fast as the source delivers them */
    const char *alarm; /* null: no alarm */
    double alarm_on_s;
    double alarm_off_s;
    uint32_t base;
    uint32_t channel;
    uint32_t content;
    const davar_dialect_t *dialect; /* of --out; null: davar's own frames */
    uint32_t node_id;
    uint32_t system_id;
    uint32_t subject_id;
    davar_telemetry_address_t address; /* these three, for a dialect */
    uint32_t baud;
    bool raw;
    bool wait;
    bool skips_torn; /* --skip-torn-reads */
    bool help;
    bool declares_filter; /* --bandwidth was given */
    davar_bandwidth_t bandwidth;
    davar_filter_t filter; /* ... at the sample rate */
    davar_config_t config;
    uint32_t taus[DAVAR_TAUS_MAX];
    double longest_tau_s; /* negative: not given */
    davar_curve_t curve;
} node_settings_t;

/* False: `why` names the option. */
bool settings_parse(node_settings_t *settings, int argc, char **argv, char *why, size_t size);

void settings_help(void);

#endif
