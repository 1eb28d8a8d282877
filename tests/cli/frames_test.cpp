// Animations by `spinel render`: a picture for each frame, named by its number, and one bad frame is one bad picture.

#include <string>
#include <vector>

#include "cli/run_program.h"
#include "image/image_io.h"

namespace spinel::frames_test {
namespace {

class CliFrames : public ProgramTest {
  protected:
    // The sphere moves, and its radius is 0 at frame 2, which is refused.
    void SetUp() override {
        ProgramTest::SetUp();
        write("scene.json", sphere_scene(R"(,
 "animation": {"fps": 10, "values": {"/objects/0/geometry/radius": "abs(0.2 - t)*5"}})"));
        write("still.json", sphere_scene());
    }
    std::vector<float> pixels(const std::string& name) const {
        const Result<Image> image = read_image(at(name));
        EXPECT_TRUE(image) << image.error().message;
        return image ? image->values : std::vector<float>();
    }
    Outcome render(const std::string& scene, const std::vector<std::string>& arguments) const {
        std::vector<std::string> all = {"render", at(scene), "--spp", "1"};
        all.insert(all.end(), arguments.begin(), arguments.end());
        return run(all);
    }
};

TEST_F(CliFrames, each_frame_is_a_picture_named_by_its_number) {
    const Outcome outcome = render("scene.json", {"--frames", "3:12:4", "-o", at("f_%04d.png"), "--quiet"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");
    EXPECT_EQ(files(),
              (std::vector<std::string>{"f_0003.png", "f_0007.png", "f_0011.png", "scene.json", "still.json"}));
    EXPECT_FALSE(pixels("f_0003.png") == pixels("f_0007.png"));
}

TEST_F(CliFrames, a_frame_alone_is_the_frame_of_the_sequence) {
    EXPECT_EQ(render("scene.json", {"--frames", "4:6", "-o", at("%d.png"), "--quiet"}).code, 0);
    EXPECT_EQ(render("scene.json", {"--frame", "5", "-o", at("five.png"), "--quiet"}).code, 0);
    EXPECT_EQ(render("scene.json", {"--frame", "10", "--fps", "20", "-o", at("slow.png"), "--quiet"}).code, 0);
    EXPECT_TRUE(pixels("5.png") == pixels("five.png"));
    EXPECT_TRUE(pixels("5.png") == pixels("slow.png"));  // both at half a second
    EXPECT_FALSE(pixels("5.png") == pixels("4.png"));
}

TEST_F(CliFrames, a_frame_that_fails_does_not_end_the_sequence) {
    const Outcome outcome = render("scene.json", {"--frames", "1:4", "-o", at("f_%d.png"), "--quiet"});
    expect_complaint(outcome, 1, "frame 2: ");
    EXPECT_NE(outcome.err.find("radius"), std::string::npos) << outcome.err;
    EXPECT_EQ(files(), (std::vector<std::string>{"f_1.png", "f_3.png", "scene.json", "still.json"}));
}

// What is wrong with the file itself is told once, not for every frame.
TEST_F(CliFrames, a_file_that_fails_is_complained_of_once) {
    const Outcome outcome = render("none.json", {"--frames", "0:50", "-o", at("f_%d.png")});
    EXPECT_EQ(outcome.code, 1);
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 2) << outcome.err;
    EXPECT_NE(outcome.err.find("50 of 50 frames"), std::string::npos) << outcome.err;
}

TEST_F(CliFrames, what_has_no_animation_is_asked_for_no_time) {
    const std::string picture = at("p_%d.png");
    expect_complaint(render("still.json", {"--fps", "24", "-o", picture}), 1,
                     "frames a second are asked for, but the scene has no \"animation\"");
    expect_complaint(render("still.json", {"--frame", "1", "-o", picture}), 1,
                     "a frame is asked for, but the scene has no \"animation\"");
    write("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    expect_complaint(render("a.off", {"--fps", "24", "-o", picture}), 1, "a model has none");
}

TEST_F(CliFrames, wrong_frames_are_refused_before_anything_is_rendered) {
    for (const char* frames : {"5", "3:3", "0:9:0", "0:4x", "0:2000000"})
        expect_complaint(render("scene.json", {"--frames=" + std::string(frames), "-o", at("f_%d.png")}), 2,
                         "--frames");
    for (const char* name : {"f.png", "f_%s.png"})
        expect_complaint(render("scene.json", {"--frames", "0:2", "-o", at(name)}), 2, "frame's number");
    EXPECT_EQ(files(), (std::vector<std::string>{"scene.json", "still.json"}));
}

}  // namespace
}  // namespace spinel::frames_test
