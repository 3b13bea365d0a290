//! A controller of four coordinated axes with learned inverses, as the laser beam needs it.

use std::fmt::Write as _;
use std::path::Path;

use model::Table;

/// Support vectors of each inverse.
const CENTRES: usize = 350;
/// Stop operators, the position, its rate.
const INPUTS: usize = 12;

/// Writes `controller.toml` and its tables; the tables' numbers are drawn, which costs the same time as
/// learned ones.
pub(crate) fn write(folder: &Path) {
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let mut draw = move || {
        state ^= state >> 12;
        state ^= state << 25;
        state ^= state >> 27;
        (state.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut text =
        String::from("piezoloop = 1\nkind = \"controller\"\nname = \"four_axes\"\nstep = 0.005\n");
    for axis in 1..=4 {
        let mut rows = vec![0.3; 1];
        rows.extend([2.0; INPUTS]);
        for _ in 0..CENTRES {
            rows.push((draw() - 0.5) / 50.0);
            rows.extend((0..INPUTS).map(|_| draw()));
        }
        let table = Table::new(INPUTS + 1, rows).expect("whole rows");
        std::fs::write(folder.join(format!("inverse{axis}.npy")), data::npy_of(&table))
            .expect("a file");
        write!(
            text,
            "\n[[axis]]\nname = \"A{axis}\"\ncommand = {{ unit = \"V\", min = 0, max = 150 }}\n\
             position = {{ unit = \"um\" }}\nmotion = {{ unit = \"1\" }}\n\n\
             [[axis.component]]\ntype = \"lssvm-stops-inverse\"\nname = \"inverse\"\n\
             table = \"inverse{axis}.npy\"\nsample_time = 0.005\nstops = 10\ncommand_high = 150\n\
             position_high = 1\n\n[[axis.component]]\ntype = \"pid\"\nkp = 20\nki = 900\nkd = 0.01\n\
             output_min = 0\noutput_max = 150\nfeedforward_gain = 0.9\n"
        )
        .expect("a text");
    }
    text.push_str(
        "\n[[coupling]]\ntype = \"jacobian-coordinator\"\naxes = [\"A1\", \"A2\", \"A3\", \"A4\"]\n\
         matrix = [\n    [504.693, 3.33402, 0, 0],\n    [14.4123, -515.344, 0, 0],\n    \
         [210.358, -12.0015, -129.337, 7.85753],\n    [1.1847, 217.263, -3.04729, -142.002],\n]\n\
         offset = [-261.625, 272.281, -46.6467, -39.121]\n",
    );
    std::fs::write(folder.join("controller.toml"), text).expect("a file");
}
