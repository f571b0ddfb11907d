//! The command lines that a mutated file is given to.

use std::path::Path;

/// What is run over a scenario at FILE with a recorded ego at EGO; files go to OUT.
const COMMANDS: [&str; 28] = [
    "inspect FILE",
    "inspect FILE --format json --ego 20",
    "inspect FILE FILE --diff --ego 20",
    "metrics FILE",
    "metrics FILE --ego 20 --scene --reasons",
    "metrics FILE --ego EGO --convention paper --format json",
    "prompt describe FILE --ego EGO",
    "prompt describe FILE --ego 20 --frame cartesian --set form=compact",
    "prompt describe FILE --ego EGO --frame metrics --format json",
    "prompt describe FILE --ego 20 --frame trajectory --obstacle 21",
    "prompt show FILE --ego EGO --task collision --format json",
    "prompt show FILE --ego 20 --task safety --frame cartesian",
    "prompt show FILE --ego EGO --task attacker",
    "ask FILE --ego EGO --task safety --model reference/geometry --no-store",
    "ask FILE --ego 20 --task collision --model reference/geometry --format json --no-store",
    "plan FILE --set replan=3 --format json",
    "plan FILE --set horizon=2 --set replan=6 --set prediction=lane -o OUT/plan.csv --log OUT/plan.log --overwrite",
    "generate FILE --candidates 6 --format json -o OUT/variants",
    "render FILE --ego EGO -o OUT/map.svg --overwrite",
    "render FILE --ego 20 --what both --size 400x300px -o OUT/both.png --overwrite",
    "render FILE --ego EGO --what screen --size 80x24 -o OUT/screen.svg --overwrite",
    "render FILE --ego 20 --what plot --view ego -o OUT/plot.svg --overwrite",
    "render FILE --ego EGO --all --size 200x150px -o OUT/animation.gif --overwrite",
    "convert FILE -o OUT/converted.xml --schema --overwrite",
    "convert FILE",
    "convert FILE -o OUT/part.xml --from 1 --around ego:20m --schema --overwrite",
    "evaluate FILE --truth auto --format=json",
    "corpus index FILE -o OUT/index --measure all --overwrite",
];

/// How many there are.
pub const COUNT: usize = COMMANDS.len();

/// The words of one of them, the program's name first.
pub fn words(number: usize, file: &Path, ego: &Path, out: &Path) -> Vec<String> {
    let path = |word: &str| {
        word.replace("FILE", &file.to_string_lossy())
            .replace("EGO", &ego.to_string_lossy())
            .replace("OUT", &out.to_string_lossy())
    };
    let words = COMMANDS[number].split(' ').map(path);
    std::iter::once("nearmiss".to_owned())
        .chain(words)
        .collect()
}
