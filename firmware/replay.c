/* davar on a bare board - the main job: a job file in, results out, through the same node loop as everywhere.
 * Command line: image JOB RESULTS. Exit status: 0 done, 3 a file, 4 no job for this build, 5 memory, 6 refused. */
#include "board.h"

#include "davar/davar.h"
#include "davar_job.h"
#include "davar_node.h"

#include <string.h>

#ifdef DAVAR_SMALL /* 16 kB of RAM */
#define CHANNELS 3U
#define POOL_WORDS 1240U
#define BUFFER_WORDS 64U
#else
#define CHANNELS 8U
#define POOL_WORDS 200000U
#define BUFFER_WORDS 1024U
#endif

enum { DONE = 0, NO_FILE = 3, NO_JOB = 4, NO_MEMORY = 5, REFUSED = 6 };

static davar_job_t job;
static davar_fit_plan_t plan;
static davar_t instances[CHANNELS];
static davar_node_channel_t channels[CHANNELS];
static davar_port_samples_t samples[CHANNELS];
static davar_node_t node;
static uint64_t pool[POOL_WORDS];
static uint64_t buffer[BUFFER_WORDS]; /* samples of all channels */
static uint64_t record[DAVAR_JOB_RESULT_WORDS];
static int input;
static int output;
static uint32_t left;    /* samples of the present block that are still in the file */
static uint32_t missing; /* lost before the next of them */

static size_t sample_bytes(void)
{
    return (job.number == DAVAR_PORT_Q15) ? sizeof(int16_t) : sizeof(int32_t);
}

/* The samples of one channel lie behind those of the one before. */
static void spread(uint32_t count)
{
    const size_t bytes = sample_bytes();
    for (uint32_t c = 0U; c < job.channels; c++) {
        samples[c].q15 = (const int16_t *)(const void *)((const char *)buffer + (c * count * bytes));
    }
}

static davar_port_read_t read_block(void *context, davar_port_block_t *block)
{
    (void)context;
    if (left == 0U) {
        uint32_t head[2] = {0U, 0U};
        if (board_read(input, head, sizeof head) != sizeof head) {
            return DAVAR_PORT_READ_FAULT;
        }
        missing = head[0];
        left = head[1];
        if (left == 0U) {
            return DAVAR_PORT_READ_END;
        }
    }
    const uint32_t count = left;
    const size_t bytes = count * job.channels * sample_bytes();
    if ((bytes > sizeof buffer) || (board_read(input, buffer, bytes) != bytes)) {
        return DAVAR_PORT_READ_FAULT;
    }
    spread(count);
    *block = (davar_port_block_t){.samples = samples, .count = count, .missing = missing};
    left -= count;
    return DAVAR_PORT_READ_BLOCK;
}

static davar_port_send_t send_result(void *context, size_t channel, const davar_result_t *result)
{
    (void)context;
    const size_t bytes = davar_job_encode_result(channel, result, record) * sizeof record[0];
    return (board_write(output, record, bytes) == bytes) ? DAVAR_PORT_SEND_DONE : DAVAR_PORT_SEND_FAULT;
}

static davar_status_t init(davar_t *davar, void *memory, size_t bytes)
{
    switch (job.number) {
    case DAVAR_PORT_Q15:
        return davar_init_q15(davar, &job.config, memory, bytes);
    case DAVAR_PORT_Q31:
        return davar_init_q31(davar, &job.config, memory, bytes);
    case DAVAR_PORT_F32:
    default:
        return davar_init_f32(davar, &job.config, memory, bytes);
    }
}

static size_t memory_words(void)
{
    const size_t bytes = (job.number == DAVAR_PORT_Q15)   ? davar_memory_size_q15(&job.config)
                         : (job.number == DAVAR_PORT_Q31) ? davar_memory_size_q31(&job.config)
                                                          : davar_memory_size_f32(&job.config);
    return (bytes + 7U) / sizeof(uint64_t);
}

static int begin(void)
{
    uint64_t words[DAVAR_JOB_WORDS];
    if (board_read(input, words, sizeof words) != sizeof words) {
        return NO_FILE;
    }
    if (!davar_job_decode(&job, words) || (job.channels == 0U) || (job.channels > CHANNELS)) {
        return NO_JOB;
    }
    job.config.fit_plan = &plan;
    const size_t each = memory_words();
    if ((each * job.channels) > POOL_WORDS) {
        return NO_MEMORY;
    }
    for (uint32_t c = 0U; c < job.channels; c++) {
        if (init(&instances[c], &pool[c * each], each * sizeof pool[0]) != DAVAR_OK) {
            return REFUSED;
        }
        channels[c] = (davar_node_channel_t){.davar = &instances[c], .number = job.number};
    }
    return DONE;
}

static int work(void)
{
    const int begun = begin();
    if (begun != DONE) {
        return begun;
    }
    const davar_port_t port = {.read = read_block, .send = send_result};
    davar_node_init(&node, channels, job.channels, &port);
    davar_node_state_t state = DAVAR_NODE_RUNNING;
    while (state == DAVAR_NODE_RUNNING) {
        state = davar_node_step(&node);
    }
    return (state == DAVAR_NODE_DONE) ? DONE : NO_FILE;
}

int main(void)
{
    static char command[256];
    board_command_line(command, sizeof command);
    char *const results = strrchr(command, ' ');
    if (results == NULL) {
        return NO_FILE;
    }
    *results = '\0';
    char *const path = strrchr(command, ' ');
    if (path == NULL) {
        return NO_FILE;
    }
    input = board_open(path + 1, false);
    output = board_open(results + 1, true);
    if ((input < 0) || (output < 0)) {
        return NO_FILE;
    }
    const int status = work();
    board_close(input);
    board_close(output);
    return status;
}
