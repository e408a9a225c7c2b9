/* Asks a tile in C for what it cannot do and says what it says, beside one sound trace: tiles FILE.rbt */
#define RBT_WRITER_IMPLEMENTATION
#include "../../contrib/rbt_writer.h"
#include "one_ray.h"

static void say(const char *what, rbt_status status, const rbt_tile *tile) {
    printf("%s: %s\n", what, status == RBT_OK ? "nothing" : tile->message);
}

int main(int count, char **arguments) {
    rbt_writer writer;
    rbt_tile tile;
    if (count != 2) return 3;
    begin(&writer, arguments[1]);
    rbt_tile_init(&tile, &writer);
    say("begin", rbt_tile_begin(&tile, 1), &tile);
    say("ray", rbt_begin_ray(&tile, 0, 0), &tile);
    say("end", rbt_tile_end(&tile), &tile);
    say("again", rbt_tile_begin(&tile, 0), &tile);
    rbt_abandon(&writer);
    say("end", rbt_tile_end(&tile), &tile);
    say("begin", rbt_tile_begin(&tile, 0), &tile);
    rbt_tile_free(&tile);

    begin(&writer, arguments[1]);
    rbt_tile_init(&tile, &writer);
    fill(&tile);
    rbt_write_tile(&writer, &tile);
    rbt_tile_free(&tile);
    return rbt_finish(&writer, 0) == RBT_OK ? 0 : 3;
}
