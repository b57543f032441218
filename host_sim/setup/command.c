/* davar programs - a command line, read with getopt_long. */
#include "setup/command.h"

#include "davar/version.h"

#include <errno.h>
#include <getopt.h>
#include <stdio.h>
#include <string.h>

#define OPTIONS_MAX 64U
#define HELP_COLUMN 26
#define ASCII_END 128
#define CODE_FIRST 256 /* getopt codes of the options; smaller codes are characters */

/* Options without a reader end the command line. */
static const option_t SHOWN[] = {{.name = "help"}, {.name = "version"}, {0}};

typedef struct {
    const command_t *command;
    void *values;
    sim_error_t *error;
    const option_t *options[OPTIONS_MAX];
    size_t count;
    const option_t *last;
} reader_t;

static void add_options(reader_t *reader, const option_t *list)
{
    for (; (list->name != NULL) || (list->help != NULL); list++) {
        if ((list->name != NULL) && (reader->count < OPTIONS_MAX)) {
            reader->options[reader->count++] = list;
        }
    }
}

static void list_options(reader_t *reader)
{
    for (const option_t *const *list = reader->command->lists; *list != NULL; list++) {
        add_options(reader, *list);
    }
    add_options(reader, SHOWN);
}

static bool apply(const reader_t *reader, const option_t *option, const char *text)
{
    return option->read(option, text, (char *)reader->values + option->offset, reader->error);
}

/* A line of the help that begins with a blank has its own indentation. */
static void print_option(const option_t *option)
{
    const int width = printf("  --%s%s%s", option->name, (option->argument != NULL) ? " " : "",
                             (option->argument != NULL) ? option->argument : "");
    int blanks = (width + 2 < HELP_COLUMN) ? (HELP_COLUMN - width) : 2;
    for (const char *line = option->help;; blanks = (*line == ' ') ? 0 : HELP_COLUMN) {
        const size_t length = strcspn(line, "\n");
        (void)printf("%*s%.*s\n", (length > 0U) ? blanks : 0, "", (int)length, line);
        if (line[length] == '\0') {
            break;
        }
        line += length + 1U;
    }
}

static void print_list(const option_t *list)
{
    for (; (list->name != NULL) || (list->help != NULL); list++) {
        if (list->name == NULL) {
            (void)printf("\n%s\n", list->help);
        } else if (list->help != NULL) {
            print_option(list);
        }
    }
}

static void print_help(const command_t *command)
{
    (void)fputs(command->before, stdout);
    for (const option_t *const *list = command->lists; *list != NULL; list++) {
        print_list(*list);
    }
    (void)printf("  --help, --version\n%s", command->after);
}

bool command_show(const command_t *command, command_status_t status, sim_error_t *error)
{
    if (status == COMMAND_HELP) {
        print_help(command);
    } else if (status == COMMAND_VERSION) {
        (void)printf("%s %d.%d.%d\n", command->name, DAVAR_VERSION_MAJOR, DAVAR_VERSION_MINOR,
                     DAVAR_VERSION_PATCH);
    } else {
        return false;
    }
    return (fflush(stdout) == 0) || sim_fail(error, "standard output: %s", strerror(errno));
}

/* getopt identifies an unknown short option by its character and all others by their position. */
static bool fail_unknown(const reader_t *reader, char **argv)
{
    if ((optopt > 0) && (optopt < ASCII_END)) {
        return sim_fail(reader->error, "unknown option '-%c' (see --help)", optopt);
    }
    if (optopt >= CODE_FIRST) {
        return sim_fail(reader->error, "--%s: takes no value",
                        reader->options[optopt - CODE_FIRST]->name);
    }
    /* After the first byte of a multi-byte character, getopt is still inside that word. */
    const bool inside = (optopt != 0) && (argv[optind] != NULL) && (argv[optind][0] == '-');
    return sim_fail(reader->error, "unknown option '%s' (see --help)",
                    argv[inside ? optind : (optind - 1)]);
}

static bool take_word(const reader_t *reader, const option_t *last, const char *word)
{
    return reader->command->read_word(reader->values, last, word, reader->error);
}

/* Handles what getopt_long found. */
static command_status_t take(reader_t *reader, int code, char **argv)
{
    bool good = false;
    if (code == 1) {
        good = take_word(reader, reader->last, optarg);
    } else if (code >= CODE_FIRST) {
        reader->last = reader->options[code - CODE_FIRST];
        if (reader->last->read == NULL) {
            return (reader->last == &SHOWN[0]) ? COMMAND_HELP : COMMAND_VERSION;
        }
        good = apply(reader, reader->last, optarg);
    } else if (code == ':') {
        good = sim_fail(reader->error, "--%s: needs a value",
                        reader->options[optopt - CODE_FIRST]->name);
    } else {
        good = fail_unknown(reader, argv);
    }
    return good ? COMMAND_RUN : COMMAND_BAD;
}

command_status_t command_read(const command_t *command, void *values, int argc, char **argv,
                              sim_error_t *error)
{
    reader_t reader = {.command = command, .values = values, .error = error};
    struct option long_options[OPTIONS_MAX + 1U] = {{0}};
    list_options(&reader);
    for (size_t i = 0; i < reader.count; i++) {
        long_options[i] = (struct option){.name = reader.options[i]->name,
                                          .has_arg = (reader.options[i]->argument != NULL),
                                          .val = CODE_FIRST + (int)i};
    }
    opterr = 0;
    command_status_t status = COMMAND_RUN;
    int code = 0;
    while ((status == COMMAND_RUN) &&
           ((code = getopt_long(argc, argv, "-:", long_options, NULL)) != -1)) {
        status = take(&reader, code, argv);
    }
    for (; (status == COMMAND_RUN) && (optind < argc); optind++) { /* words after "--" */
        status = take_word(&reader, NULL, argv[optind]) ? COMMAND_RUN : COMMAND_BAD;
    }
    return status;
}

bool command_set(const command_t *command, void *values, const char *name, const char *text,
                 sim_error_t *error)
{
    reader_t reader = {.command = command, .values = values, .error = error};
    list_options(&reader);
    for (size_t i = 0; i < reader.count; i++) {
        if ((strcmp(reader.options[i]->name, name) == 0) && (reader.options[i]->read != NULL)) {
            return apply(&reader, reader.options[i], text);
        }
    }
    return sim_fail(error, "--%s: no such option", name);
}
