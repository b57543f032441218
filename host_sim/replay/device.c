/* davar-sim - runs a device through two files. Blocks are small enough for a board with 16 kB of
 * RAM. */
#include "replay/device.h"

#include "common/spool.h"
#include "davar_job.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#define BLOCK_BYTES 512U
#define FOLDER_BYTES 512U

typedef struct {
    char folder[FOLDER_BYTES];
    char job[FOLDER_BYTES + 16U];
    char results[FOLDER_BYTES + 16U];
} places_t;

static bool make_places(places_t *places, sim_error_t *error)
{
    const int length =
        snprintf(places->folder, sizeof places->folder, "%s/davar-device-XXXXXX", spool_folder());
    if ((length < 0) || ((size_t)length >= sizeof places->folder) ||
        (mkdtemp(places->folder) == NULL)) {
        return sim_fail(error, "--device: cannot create a folder for its files in %s (TMPDIR)",
                        spool_folder());
    }
    (void)snprintf(places->job, sizeof places->job, "%s/job", places->folder);
    (void)snprintf(places->results, sizeof places->results, "%s/results", places->folder);
    return true;
}

static void remove_places(const places_t *places)
{
    (void)unlink(places->job);
    (void)unlink(places->results);
    (void)rmdir(places->folder);
}

static void write_part(FILE *file, const davar_port_block_t *block, const engine_t *engine,
                       size_t from, size_t count)
{
    const uint32_t head[2] = {(from == 0U) ? block->missing : 0U, (uint32_t)count};
    const size_t bytes = (engine->number == DAVAR_PORT_Q15) ? sizeof(int16_t) : sizeof(int32_t);
    (void)fwrite(head, sizeof head, 1U, file);
    for (size_t c = 0; c < engine->count; c++) {
        (void)fwrite((const char *)block->samples[c].q15 + from * bytes, bytes, count, file);
    }
}

static void write_block(FILE *file, const davar_port_block_t *block, const engine_t *engine)
{
    const size_t most = BLOCK_BYTES / (sizeof(int32_t) * engine->count);
    const size_t size = (most == 0U) ? 1U : most;
    for (size_t from = 0; from < block->count; from += size) {
        const size_t left = block->count - from;
        write_part(file, block, engine, from, (left < size) ? left : size);
    }
}

static bool write_job(const places_t *places, replay_t *replay, const engine_t *engine,
                      sim_error_t *error)
{
    FILE *file = fopen(places->job, "wb");
    if (file == NULL) {
        return sim_fail(error, "%s: cannot be written", places->job);
    }
    uint64_t words[DAVAR_JOB_WORDS];
    davar_job_encode(&engine->config, engine->curve.cascade.tau_count, engine->number,
                     (uint32_t)engine->count, engine->declared, words);
    (void)fwrite(words, sizeof words, 1U, file);
    const davar_port_t port = replay_port(replay);
    davar_port_block_t block = {0};
    davar_port_read_t state = port.read(port.context, &block);
    while (state == DAVAR_PORT_READ_BLOCK) {
        write_block(file, &block, engine);
        state = port.read(port.context, &block);
    }
    const uint32_t end[2] = {0U, 0U};
    (void)fwrite(end, sizeof end, 1U, file);
    const bool written = (ferror(file) == 0);
    if ((fclose(file) != 0) || !written) {
        return sim_fail(error, "%s: cannot be written", places->job);
    }
    return state == DAVAR_PORT_READ_END;
}

/* The meaning of the image's exit status (firmware/job_file.h). */
static const char *cause(int status, bool has_cascade)
{
    switch (status) {
    case 4:
        return has_cascade ? "the device supports fewer cluster sizes or channels: shorten --taus "
                             "or --longest-tau, or give fewer columns"
                           : "the device supports fewer cluster sizes or channels";
    case 5:
        return has_cascade
                   ? "the device has too little memory for this window, these channels and the "
                     "cascade of --longest-tau: shorten --window-max or --longest-tau"
                   : "the device has too little memory for this window and these channels";
    case 6:
        return "the device rejected the settings";
    default:
        return "the device failed";
    }
}

static bool run_device(const char *command, const places_t *places, bool has_cascade,
                       sim_error_t *error)
{
    char line[4096];
    if (snprintf(line, sizeof line, "%s %s %s", command, places->job, places->results) >=
        (int)sizeof line) {
        return sim_fail(error, "--device: the command is too long");
    }
    const int status = system(line); /* NOLINT(cert-env33-c): the option takes a command line */
    const int code = ((status != -1) && WIFEXITED(status)) ? WEXITSTATUS(status) : -1;
    return (code == 0) ||
           sim_fail(error, "--device: %s (exit status %d)", cause(code, has_cascade), code);
}

typedef struct {
    FILE *file;
    const char *path;
    size_t channels;
    size_t rest;    /* words of a result after its head */
    size_t healths; /* health records so far; they are the last words of a complete file */
    davar_health_t health;
} results_t;

static bool fail_broken(const results_t *results, sim_error_t *error)
{
    return sim_fail(error, "%s: the device's results are incomplete", results->path);
}

static bool take_result(results_t *results, replay_t *replay, uint64_t *words, sim_error_t *error)
{
    static davar_result_t result;
    static davar_glr_report_t report;
    const size_t rest = davar_job_result_rest(words);
    size_t channel;
    if ((rest != results->rest) ||
        (fread(&words[DAVAR_JOB_HEAD], sizeof words[0], rest, results->file) != rest)) {
        return fail_broken(results, error);
    }
    davar_job_decode_result(&channel, &result, &report, words);
    if (channel >= results->channels) {
        return fail_broken(results, error);
    }
    return (replay == NULL) ||
           (replay_send(replay, channel, &result, &report) == DAVAR_PORT_SEND_DONE);
}

/* Reads all results. Without a replay it only checks that the file is complete. */
static bool take_all(results_t *results, replay_t *replay, sim_error_t *error)
{
    uint64_t words[DAVAR_JOB_RESULT_WORDS];
    rewind(results->file);
    results->healths = 0U;
    results->health = (davar_health_t){0};
    while (results->healths < results->channels) {
        davar_health_t health;
        size_t channel;
        if (fread(words, sizeof words[0], DAVAR_JOB_HEAD, results->file) != DAVAR_JOB_HEAD) {
            return fail_broken(results, error);
        }
        if (davar_job_decode_health(&channel, &health, words)) {
            engine_add_health(&results->health, &health);
            results->healths++;
        } else if (!take_result(results, replay, words, error)) {
            return false;
        }
    }
    return true;
}

static bool read_results(const places_t *places, replay_t *replay, const engine_t *engine,
                         davar_health_t *health, sim_error_t *error)
{
    results_t results = {.file = fopen(places->results, "rb"),
                         .path = places->results,
                         .channels = engine->count,
                         .rest = (6U * (size_t)engine->curve.tau_count) +
                                 ((size_t)4U * DAVAR_COEFFICIENT_COUNT)};
    if (results.file == NULL) {
        return sim_fail(error, "%s: the device wrote no results", places->results);
    }
    const bool good = take_all(&results, NULL, error) && take_all(&results, replay, error);
    (void)fclose(results.file);
    *health = results.health;
    return good;
}

bool device_replay(const char *command, replay_t *replay, const engine_t *engine,
                   davar_health_t *health, sim_error_t *error)
{
    places_t places;
    if (!make_places(&places, error)) {
        return false;
    }
    const bool good = write_job(&places, replay, engine, error) &&
                      run_device(command, &places, engine->curve.cascade.tau_count > 0U, error) &&
                      read_results(&places, replay, engine, health, error);
    remove_places(&places);
    return good;
}
