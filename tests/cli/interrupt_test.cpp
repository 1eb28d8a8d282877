// Ctrl-C and SIGTERM end a render early, and what there is is saved whole.

#include <atomic>
#include <nlohmann/json.hpp>
#include <string>

#include "cli/run_program.h"
#include "image/image_io.h"

namespace spinel::interrupt_test {
namespace {

class CliInterrupt : public ProgramTest {
  protected:
    // Starts a render that would take days, interrupts it, and looks at what it leaves.
    void expect_saved(int signal, const std::string& name, std::vector<std::string> more = {}) {
        SCOPED_TRACE(name);
        write("scene.json", sphere_scene());
        std::vector<std::string> arguments = {"render", at("scene.json"), "-o",    at(name),
                                              "--spp",  "1000000000",     "--json"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        Child child = start(arguments);
        std::this_thread::sleep_for(std::chrono::milliseconds(1500));
        EXPECT_FALSE(std::filesystem::exists(at(name))) << "there is no picture before the end";
        // From the signal on, whoever sees the final name sees a whole picture.
        std::atomic<bool> ended = false;
        std::thread watcher([&] {
            while (!ended) {
                if (!std::filesystem::exists(at(name))) continue;
                EXPECT_TRUE(read_image(at(name)));
                break;
            }
        });
        child.send(signal);
        const Outcome outcome = child.wait(20);
        ended = true;
        watcher.join();
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        const auto json = nlohmann::json::parse(outcome.out);
        EXPECT_EQ(json["stopped_by"], "interrupted");
        EXPECT_GT(json["spp"].get<double>(), 1);
        const Result<Image> image = read_image(at(name));
        ASSERT_TRUE(image) << image.error().message;
        EXPECT_EQ(image->width, 24);
        EXPECT_EQ(files(), (std::vector<std::string>{name, "scene.json"}));
        // The corner is the sky in every sample that there was: the mean is of those samples, not of those
        // asked for.
        if (name.ends_with(".exr")) { EXPECT_NEAR(image->at(0, 0)[0], 1.0f, 1e-5f); }
        std::filesystem::remove(at(name));
    }
};

TEST_F(CliInterrupt, sigint_saves_a_png) { expect_saved(SIGINT, "a.png"); }
TEST_F(CliInterrupt, sigint_saves_an_exr) { expect_saved(SIGINT, "a.exr", {"--threads", "1"}); }
TEST_F(CliInterrupt, sigterm_saves_a_png) { expect_saved(SIGTERM, "a.png", {"--time", "5h"}); }
TEST_F(CliInterrupt, sigterm_saves_an_exr) { expect_saved(SIGTERM, "a.exr", {"--noise", "0.000001"}); }

TEST_F(CliInterrupt, an_interrupted_batch_keeps_what_is_done_and_begins_nothing_new) {
    write("a.json", sphere_scene());
    write("b.json", sphere_scene());
    Child child =
        start({"render", at("a.json"), at("b.json"), "-o", at("{name}.png"), "--spp", "1000000000", "--quiet"});
    std::this_thread::sleep_for(std::chrono::milliseconds(1500));
    child.send(SIGINT);
    const Outcome outcome = child.wait(20);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(files(), (std::vector<std::string>{"a.json", "a.png", "b.json"}));
}

TEST_F(CliInterrupt, an_old_picture_stays_whole_when_the_render_is_killed) {
    write("scene.json", sphere_scene());
    write("a.png", "an old picture");
    Child child = start({"render", at("scene.json"), "-o", at("a.png"), "--spp", "1000000000", "--quiet"});
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    child.send(SIGKILL);
    EXPECT_EQ(child.wait(20).code, -1);
    EXPECT_EQ(bytes_of(at("a.png")), "an old picture");
    EXPECT_EQ(files(), (std::vector<std::string>{"a.png", "scene.json"}));
}

}  // namespace
}  // namespace spinel::interrupt_test
