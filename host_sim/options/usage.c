/* davar-sim - the help text. */
#include "options/usage.h"

#include "davar/version.h"

/* In parts, because C99 compilers need not support longer literals. */
static const char *const TEXT[] = {
    "usage: davar-sim REC [options]\n"
    "\n"
    "Runs a recorded gyro signal through the davar library. For each window it prints the angle\n"
    "random walk (ARW) and related values. The arithmetic is the same as on a microcontroller.\n"
    "\n"
    "REC: CSV, plain or gzip; '-' is standard input. Optional '# key: value' lines, a header\n"
    "row, then numbers. Columns are named <quantity>_<unit>: time_s, gyro_x_dps, gyro_y_rad_s,\n"
    "gyro_z_counts, temp_degC, ...\n"
    "\n",

    "Recording\n"
    "  --column NAME ...       columns to process: repeat the option, or separate names by\n"
    "                          commas; after REC also by spaces (default: the first column\n"
    "                          named gyro_*, otherwise the only one that is not time_s)\n"
    "  --rate HZ               sample rate (default: from the median time step)\n"
    "  --bandwidth FILTER      what the gyro's noise passed before it was recorded (default:\n"
    "                          unknown; the fit then withholds its result where the short\n"
    "                          cluster sizes read low):\n"
    "                          HZ[:ORDER[:PERCENT]]: a low-pass of 1 or 2 poles (default 2),\n"
    "                          -3 dB at HZ, known to PERCENT (default 10)\n"
    "                          average[ORDER]:N: ORDER (default 1) moving averages of N samples,\n"
    "                          together at most 1024\n"
    "                          cic[ORDER]:N: the same, keeping every N-th sample\n"
    "                          sum:N: sums of N counts (davar_average of the library)\n"
    "                          HZ+average:N: a low-pass, then one of these; none: no filter\n"
    "                          auto: learned for each column from the whole recording, which\n"
    "                          needs 4352 samples at rest; standard error reports the result\n"
    "  --gap FACTOR            a time step longer than FACTOR sample periods is a gap (default\n"
    "                          1.5; off with --rate)\n"
    "  --skip-torn-reads       skip rows with a torn register read: a single sample that\n"
    "                          jumps by a power of two in counts and back. Each makes a gap.\n"
    "                          Standard error has their number (needs --lsb)\n"
    "\n"
    "Arithmetic\n"
    "  --arith fixed|float     integer counts, or float32 samples (default fixed)\n"
    "  --lsb UNIT_PER_COUNT    size of a count in deg/s, or in the unit of the column (default:\n"
    "                          the smallest power of two with which the recording fits 32 bits)\n"
    "  --bits 16|24|32         width of a count; a larger value is an error (default 24; needs\n"
    "                          --lsb)\n"
    "  --full-scale DPS        with --arith float: larger samples saturate (default: a power of\n"
    "                          two that covers the recording)\n"
    "\n",

    "Window, in samples\n"
    "  --law fixed|kurtosis|or|and|glr  rule for the window length (default or: kurtosis OR\n"
    "                          contribution; glr: a likelihood ratio test starts the window\n"
    "                          where the noise changed)\n"
    "  --mode centred|trailing  the epoch is the centre of the window, or its newest sample\n"
    "                          (default centred; glr, --device: always trailing)\n"
    "  --window-max N          longest window (default 600; glr: 600 blocks)\n"
    "  --window-min N          shortest window (default 2/3 of the longest; glr: 2 blocks)\n"
    "  --segment N             short segment of the contribution test (default 1/6 of the\n"
    "                          longest window; glr: 0)\n"
    "  --kurtosis K1:K2        stable range of the kurtosis (default 2.5:3.3)\n"
    "  --contribution S1:S2    stable range of the sliding kurtosis contribution (default\n"
    "                          0:0.07)\n"
    "  --unstable-rate X       instead of both ranges: the share of windows of unchanged noise\n"
    "                          that may be unstable, 0.0001 to 0.1. It counts for every length\n"
    "                          of the window and for the filter of --bandwidth\n"
    "  --grow N, --shrink N    change of the length per sample (default 2; trailing windows\n"
    "                          grow by 1; glr shrinks by at least 64)\n"
    "  --taus octave|geometric[:N]|N,N,...  cluster sizes (default octave; geometric: 12)\n"
    "  --longest-tau S         further octaves of cluster sizes, up to S seconds, beyond the\n"
    "                          window: columns adev_M, and coefficients of the whole curve. Each\n"
    "                          size remembers its last 34 to 66 clusters before the newest\n"
    "                          sample, in centred mode too\n"
    "\n"
    "Only for --law glr\n"
    "  --false-alarms-per-hour X  accepted false alarms per hour of unchanged noise (default\n"
    "                          0.01)\n"
    "  --cut-interval S        accepted mean time between false cuts of the window, in seconds\n"
    "                          (default 300)\n"
    "  --block N               samples per block (default 10)\n"
    "  --shock-blocks N        longest shock, in blocks (default 2)\n"
    "\n",

    "Output\n"
    "  --stride K              one result every K samples (default 1)\n"
    "  --engine auto|grid      algorithm for strides: equal results, different cost\n"
    "  --out csv|jsonl|can:IFACE|slcan:PATH  format (default csv), or a CAN interface or tty\n"
    "                          for frames; slcan:pty creates a pty and prints its name\n"
    "  --out mavlink:udp:HOST:PORT|mavlink:serial:PATH|dronecan:IFACE|cyphal:IFACE\n"
    "                          messages of an autopilot (docs/DIALECTS.md)\n"
    "  --can-base HEX          CAN identifier of the first channel (default 5D0); each further\n"
    "                          channel adds hexadecimal 10\n"
    "  --can-content summary|full|intervals|fd\n"
    "                          frames of a result: 6 frames, all values (default), also limits,\n"
    "                          one CAN FD frame\n"
    "  --raw                   also send frames of the samples, for davarlab live --raw\n"
    "  --baud N                baud rate of the serial line (default: unchanged)\n"
    "  --model-table FILE      compare each result with an error model (davarlab export MODEL\n"
    "                          -o FILE.csv). Adds the columns model_health (above 1: the model\n"
    "                          does not fit) and model_deviation_M, or frames DAVAR_Monitor\n"
    "  --device COMMAND        run on a device: COMMAND JOB RESULTS (see port/job/davar_job.h\n"
    "                          and tools/davar-mcu)\n"
    "  --details               more columns: intervals of ADEVs and coefficients, difference "
    "counts,\n"
    "                          gaps, coarse, upper bounds of absent coefficients\n"
    "  --pace max|realtime|X   speed as a multiple of real time (default max)\n"
    "  --progress auto|always|never  progress on standard error (default auto: on a terminal)\n"
    "  --help, --version\n"
    "\n"
    "If the window cannot support a value, its field is empty (null in jsonl).\n"
    "Exit status: 0 done, 2 bad recording or option (one line on standard error).\n"
    "\n"
    "Examples\n"
    "  davar-sim flight.csv.gz --lsb 0.05 --stride 100 > arw.csv\n"
    "  davar-sim flight.csv --column gyro_x_dps gyro_y_dps --law fixed --window-max 6000 --out "
    "jsonl\n"
    "  zcat flight.csv.gz | davar-sim - --rate 99.3 --mode trailing --pace realtime\n",
};

void usage_print(FILE *file)
{
    for (size_t i = 0; i < sizeof TEXT / sizeof TEXT[0]; i++) {
        (void)fputs(TEXT[i], file);
    }
}

void version_print(FILE *file)
{
    (void)fprintf(file, "davar-sim %d.%d.%d\n", DAVAR_VERSION_MAJOR, DAVAR_VERSION_MINOR,
                  DAVAR_VERSION_PATCH);
}
