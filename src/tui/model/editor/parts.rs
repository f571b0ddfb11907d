//! Parts of the editor: its area on the screen, styles and clipboard.

use std::cell::RefCell;
use std::rc::Rc;

use edtui::clipboard::ClipboardTrait;

/// Position of the text on the screen.
#[derive(Debug, Default, Clone)]
pub struct EditorDrawn {
    /// Cells of the text, without line numbers: column, row, columns, rows.
    pub area: (u16, u16, u16, u16),
    /// For each row its line, and the range of its characters.
    pub rows: Vec<(usize, std::ops::Range<usize>)>,
}

/// Styles of characters, by line from one on, and for which text and colours they hold.
#[derive(Debug, Default)]
pub struct Styles {
    /// Stands for the text and the colours.
    pub of: u64,
    /// The first line.
    pub from: usize,
    /// A style for each character.
    pub lines: Vec<Vec<ratatui::style::Style>>,
}

/// The clipboard inside the program, and whether something was put into it since it was last asked.
#[derive(Default)]
pub struct Clip {
    /// Its text.
    pub text: String,
    /// Whether that is new.
    pub fresh: bool,
}

/// The clipboard as the crate takes it.
pub struct Shared(pub Rc<RefCell<Clip>>);

impl ClipboardTrait for Shared {
    fn set_text(&mut self, text: String) {
        let mut clip = self.0.borrow_mut();
        clip.text = text;
        clip.fresh = true;
    }

    fn get_text(&mut self) -> String {
        self.0.borrow().text.clone()
    }
}
