/* davar tests - links of Linux: the address of a host, and a packet that was cut. This file has its
 * own name server. */
#include "link.h"
#include "unity.h"

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <string.h>
#include <sys/time.h>
#include <unistd.h>

static struct sockaddr_in6 six = {.sin6_family = AF_INET6, .sin6_port = 9};
static struct sockaddr_in four = {.sin_family = AF_INET};
static struct addrinfo second = {
    .ai_family = AF_INET, .ai_addrlen = sizeof four, .ai_addr = (struct sockaddr *)&four};
static struct addrinfo first = {.ai_family = AF_INET6,
                                .ai_addrlen = sizeof six,
                                .ai_addr = (struct sockaddr *)&six,
                                .ai_next = &second};
static uint32_t questions;

/* Instead of the C library's: localhost, IPv6 first. */
static int own_getaddrinfo(const char *host, const char *port, const struct addrinfo *wanted,
                           struct addrinfo **found)
{
    (void)port;
    (void)wanted;
    questions++;
    *found = &first;
    return (strcmp(host, "localhost") == 0) ? 0 : EAI_NONAME;
}

static void own_freeaddrinfo(struct addrinfo *found)
{
    (void)found;
}

#define getaddrinfo own_getaddrinfo
#define freeaddrinfo own_freeaddrinfo
#include "link_udp.c" /* NOLINT(bugprone-suspicious-include) */

void setUp(void)
{
    six.sin6_addr = in6addr_loopback;
    four.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    questions = 0U;
}

void tearDown(void) {}

static davar_link_t *open_link(const char *where)
{
    char why[128];
    const davar_link_options_t options = {.where = where, .wait = true};
    return davar_link_open(&options, why, sizeof why);
}

static void test_a_host_is_resolved_once_and_reached_by_ipv4(void)
{
    socklen_t bytes = sizeof four;
    char got[8];
    const davar_packet_t packet = {.length = 3U, .data = "abc"};
    const int receiver = socket(AF_INET, SOCK_DGRAM, 0);
    const struct timeval patience = {.tv_sec = 10};
    four.sin_port = 0;
    TEST_ASSERT_EQUAL(0, setsockopt(receiver, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience));
    TEST_ASSERT_EQUAL(0, bind(receiver, (const struct sockaddr *)&four, bytes));
    TEST_ASSERT_EQUAL(0, getsockname(receiver, (struct sockaddr *)&four, &bytes));
    davar_link_t *link = open_link("mavlink:udp:localhost:14550");
    TEST_ASSERT_NOT_NULL(link);
    for (uint32_t turn = 0U; turn < 2U; turn++) {
        TEST_ASSERT_EQUAL(DAVAR_PORT_SEND_DONE, davar_link_send(link, &packet));
        TEST_ASSERT_EQUAL(3, recv(receiver, got, sizeof got, 0));
        link_lost(link);
        davar_link_wait(link, LINK_RETRY_MS + 10U);
        TEST_ASSERT_TRUE(davar_link_is_up(link));
    }
    TEST_ASSERT_EQUAL(1, questions);
    davar_link_close(link);
    (void)close(receiver);
}

static void test_an_unknown_host_is_no_link_to_wait_for(void)
{
    TEST_ASSERT_NULL(open_link("mavlink:udp:nowhere:14550"));
}

static uint32_t dropped_of(const davar_dialect_t *dialect, size_t pending)
{
    davar_link_t link = {.dialect = dialect, .pending = pending};
    link_give_up(&link);
    TEST_ASSERT_EQUAL(0, link.pending);
    return link.count[DAVAR_HEALTH_FRAMES_DROPPED];
}

/* The last byte of a line of SLCAN is its end, that of a packet of MAVLink its checksum. */
static void test_a_packet_without_its_last_byte_is_dropped_and_a_line_is_not(void)
{
    TEST_ASSERT_EQUAL(0, dropped_of(NULL, 0U));
    TEST_ASSERT_EQUAL(0, dropped_of(NULL, 1U));
    TEST_ASSERT_EQUAL(1, dropped_of(NULL, 2U));
    TEST_ASSERT_EQUAL(0, dropped_of(&davar_mavlink, 0U));
    TEST_ASSERT_EQUAL(1, dropped_of(&davar_mavlink, 1U));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_host_is_resolved_once_and_reached_by_ipv4);
    RUN_TEST(test_an_unknown_host_is_no_link_to_wait_for);
    RUN_TEST(test_a_packet_without_its_last_byte_is_dropped_and_a_line_is_not);
    return UNITY_END();
}
