/* Calls the writer in C out of order and says what it says, beside one sound trace: order FILE.rbt */
#define RBT_WRITER_IMPLEMENTATION
#include "../../contrib/rbt_writer.h"
#include "one_ray.h"

static void say(const char *what, rbt_status status, const rbt_writer *writer) {
    printf("%s: %s\n", what, status == RBT_OK ? "nothing" : writer->message);
}

int main(int count, char **arguments) {
    rbt_writer writer, other;
    rbt_tile tile;
    char beside[1000];
    if (count != 2) return 3;
    snprintf(beside, sizeof beside, "%.900s.rbt", arguments[1]);

    begin(&writer, arguments[1]);
    begin(&other, beside);
    rbt_tile_init(&tile, &other);
    fill(&tile);
    say("another", rbt_write_tile(&writer, &tile), &writer);
    rbt_abandon(&writer);
    rbt_abandon(&other);
    say("abandoned", rbt_write_tile(&other, &tile), &other);
    say("abandoned", rbt_finish(&other, 0), &other);
    rbt_tile_free(&tile);

    begin(&writer, arguments[1]);
    rbt_tile_init(&tile, &writer);
    fill(&tile);
    rbt_write_tile(&writer, &tile);
    if (rbt_finish(&writer, 0) != RBT_OK) return 3;
    rbt_abandon(&writer);
    if (writer.status != RBT_OK) return 3;
    say("finished", rbt_write_tile(&writer, &tile), &writer);
    say("finished", rbt_finish(&writer, 0), &writer);
    rbt_tile_free(&tile);
    return 0;
}
