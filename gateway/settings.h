/* davar-node - the values of the command line, and the configuration that follows. */
#ifndef NODE_SETTINGS_H
#define NODE_SETTINGS_H

#include "davar/filter.h"
#include "davar_link.h"
#include "setup/setup.h"

typedef struct {
    setup_t setup; /* what davar-sim has too */
    const char *source;
    const char *out;
    const char *edges; /* null: samples arrive as fast as the source delivers them */
    const char *alarm; /* null: no alarm */
    double alarm_on_s;
    double alarm_off_s;
    uint32_t bits;
    uint32_t channel;
    optional_u32_t node_id; /* these three: for a dialect */
    optional_u32_t system_id;
    optional_u32_t subject_id;
    bool wait;
    bool floor;
    const davar_dialect_t *dialect; /* of --out; null: davar's own frames */
    davar_telemetry_address_t address;
    davar_config_t config;
    uint32_t taus[DAVAR_TAUS_MAX];
    davar_filter_t filter; /* at the sample rate */
    davar_curve_t curve;
    davar_floor_plan_t floor_plan; /* with --floor */
} node_settings_t;

/* The table of all options. */
extern const command_t settings_command;

/* Reads the command line. COMMAND_BAD: the message names the option. */
command_status_t settings_parse(node_settings_t *settings, int argc, char **argv,
                                sim_error_t *error);

#endif
