/* davar tests - the main program of a fuzz target without libFuzzer: runs it once on each file of
 * the folders on the command line, in any kind of build. */
#include "fuzzing.h"

#include <dirent.h>

/* A copy of exactly the file's size, so that a sanitizer detects access beyond it. */
static void run_file(const char *name)
{
    FILE *const file = fopen(name, "rb");
    REQUIRE((file != NULL) && (fseek(file, 0L, SEEK_END) == 0));
    const long size = ftell(file);
    REQUIRE((size >= 0L) && (fseek(file, 0L, SEEK_SET) == 0));
    uint8_t *const data = malloc((size > 0L) ? (size_t)size : 1U);
    REQUIRE((data != NULL) && (fread(data, 1U, (size_t)size, file) == (size_t)size));
    (void)fclose(file);
    (void)LLVMFuzzerTestOneInput(data, (size_t)size);
    free(data);
}

int main(int argc, char *argv[])
{
    unsigned inputs = 0U;
    for (int i = 1; i < argc; i++) {
        DIR *const folder = opendir(argv[i]);
        REQUIRE(folder != NULL);
        for (const struct dirent *entry = readdir(folder); entry != NULL; entry = readdir(folder)) {
            char name[4096];
            if (entry->d_name[0] != '.') {
                (void)snprintf(name, sizeof name, "%s/%s", argv[i], entry->d_name);
                run_file(name);
                inputs++;
            }
        }
        (void)closedir(folder);
    }
    printf("%u inputs\n", inputs);
    return (inputs > 0U) ? 0 : 1;
}
