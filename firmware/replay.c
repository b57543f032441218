/* davar on a bare board - runs a job: a job file in, results out, through the same node loop as
 * everywhere. Command line: image JOB RESULTS. Exit status: see job_file.h. */
#include "board.h"
#include "job_file.h"

#include "davar_node.h"

#include <string.h>

static job_file_t input;
static davar_t instances[JOB_FILE_CHANNELS];
static davar_node_channel_t channels[JOB_FILE_CHANNELS];
static davar_node_t node;
static uint64_t record[DAVAR_JOB_RESULT_WORDS];
static int output;

static davar_port_send_t send_result(void *context, size_t channel, const davar_result_t *result)
{
    davar_glr_report_t report;
    (void)context;
    davar_glr_report(&instances[channel], &report);
    const size_t bytes =
        davar_job_encode_result(channel, result, &report, record) * sizeof record[0];
    return (board_write(output, record, bytes) == bytes) ? DAVAR_PORT_SEND_DONE
                                                         : DAVAR_PORT_SEND_FAULT;
}

static bool write_health(void)
{
    bool good = true;
    for (uint32_t c = 0U; good && (c < input.job.channels); c++) {
        const davar_health_t health = davar_health(&instances[c]);
        uint64_t head[DAVAR_JOB_HEAD];
        davar_job_encode_health(c, &health, head);
        good = (board_write(output, head, sizeof head) == sizeof head);
    }
    return good;
}

static int work(void)
{
    const davar_port_t port = {.context = &input, .read = job_file_read, .send = send_result};
    for (uint32_t c = 0U; c < input.job.channels; c++) {
        channels[c] = (davar_node_channel_t){.davar = &instances[c],
                                             .number = input.job.number,
                                             .cascade = job_file_cascade(&input, c),
                                             .plan = &input.plan};
    }
    davar_node_init(&node, channels, input.job.channels, &port);
    davar_node_state_t state = DAVAR_NODE_RUNNING;
    while (state == DAVAR_NODE_RUNNING) {
        state = davar_node_step(&node);
    }
    return ((state == DAVAR_NODE_DONE) && write_health()) ? JOB_DONE : JOB_NO_FILE;
}

int main(void)
{
    static char command[256];
    char *words[3];
    if (board_words(command, sizeof command, words, 3U) != 3U) {
        return JOB_NO_FILE;
    }
    output = board_open(words[2], true);
    if (output < 0) {
        return JOB_NO_FILE;
    }
    const int opened = job_file_open(&input, words[1], instances);
    const int status = (opened == JOB_DONE) ? work() : opened;
    board_close(output);
    return status;
}
